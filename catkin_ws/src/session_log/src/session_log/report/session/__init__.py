# SPDX-License-Identifier: BSD-3-Clause
"""What one session holds, as the report needs it."""
