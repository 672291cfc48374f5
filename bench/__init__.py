# SPDX-License-Identifier: BSD-3-Clause
"""Measures what the README claims: each beside its target, with the machine and the date."""
