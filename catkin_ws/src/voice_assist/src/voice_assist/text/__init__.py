# SPDX-License-Identifier: BSD-3-Clause
"""Words: normalisation, Word Error Rate, phonetic distance."""
