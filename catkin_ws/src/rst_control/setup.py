# SPDX-License-Identifier: BSD-3-Clause
"""Tells catkin where the Python package lies."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(**generate_distutils_setup(packages=["rst_control"], package_dir={"": "src"}))
