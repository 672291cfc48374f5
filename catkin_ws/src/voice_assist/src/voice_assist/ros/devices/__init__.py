# SPDX-License-Identifier: BSD-3-Clause
"""The node that calls the devices of the theatre."""
