# SPDX-License-Identifier: BSD-3-Clause
"""Sound through the pipeline, in pieces that are kept by what the pipeline decides."""
