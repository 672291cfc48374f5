# SPDX-License-Identifier: BSD-3-Clause
"""What callers ask of the controller: its services, its action, and the topic of commands."""
