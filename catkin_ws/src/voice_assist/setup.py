# SPDX-License-Identifier: BSD-3-Clause
"""Tells catkin where the Python package lies."""

from setuptools import setup

from catkin_pkg.python_setup import generate_distutils_setup

setup(**generate_distutils_setup(packages=["voice_assist"], package_dir={"": "src"}))
