# SPDX-License-Identifier: BSD-3-Clause
"""What keeps the documents true: generated pages, long sentences, the version of a release."""
