# SPDX-License-Identifier: BSD-3-Clause
"""Each part of the running system killed or stopped in mid-motion."""
