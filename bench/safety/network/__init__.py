# SPDX-License-Identifier: BSD-3-Clause
"""Voice and controller on two hosts, and a bad network between them."""
