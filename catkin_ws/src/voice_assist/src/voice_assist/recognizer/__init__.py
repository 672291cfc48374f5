# SPDX-License-Identifier: BSD-3-Clause
"""From sound to text, by Whisper models of any size."""

from voice_assist.recognizer.recognizer import Recognizer
from voice_assist.recognizer.whisper import load_recognizer

__all__ = ["Recognizer", "load_recognizer"]
