# SPDX-License-Identifier: BSD-3-Clause
"""Sound from a device: a microphone by its name, and whether anybody could be heard by it."""
