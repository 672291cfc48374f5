# SPDX-License-Identifier: BSD-3-Clause
"""Commands at random, and an oracle that says which of them the gate must refuse."""
