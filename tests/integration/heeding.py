# SPDX-License-Identifier: BSD-3-Clause
"""Programs that tests end as a person would."""

import signal


def heed():
    """In the child: heed Ctrl-C and a closed terminal, also where tests run in the background.

    There a shell, or `nohup`, has them ignored, and a child would inherit that.
    """
    for request in (signal.SIGHUP, signal.SIGINT):
        signal.signal(request, signal.SIG_DFL)
