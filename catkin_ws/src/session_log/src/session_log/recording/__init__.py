# SPDX-License-Identifier: BSD-3-Clause
"""What is recorded of a session, and its metadata."""
