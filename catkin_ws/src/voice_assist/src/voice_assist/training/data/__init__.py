# SPDX-License-Identifier: BSD-3-Clause
"""Sound and text to train on."""
