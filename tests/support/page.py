# SPDX-License-Identifier: BSD-3-Clause
"""Scripts that do in the operator's page what a person does there."""


def text(name):
    """What a part of the page says."""
    return f"document.getElementById('{name}').textContent"


def click(name):
    """Press a button."""
    return f"document.getElementById('{name}').click()"


def enter(token):
    """Give the page its token."""
    return (
        f"document.getElementById('token').value = {token!r},"
        "document.getElementById('unlock').requestSubmit()"
    )


def click_picture(x, y):
    """Click at shares of the picture's width and height."""
    return (
        "((i, b) => i.dispatchEvent(new MouseEvent('click', {bubbles: true,"
        f"clientX: b.left + {x} * b.width, clientY: b.top + {y} * b.height"
        "})))(document.getElementById('picture'),"
        "document.getElementById('picture').getBoundingClientRect())"
    )
