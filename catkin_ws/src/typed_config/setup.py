# SPDX-License-Identifier: BSD-3-Clause
"""Where catkin finds the Python packages."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import find_packages, setup

setup(
    **generate_distutils_setup(
        packages=find_packages("src"),
        package_dir={"": "src"},
        package_data={"typed_config": ["py.typed"]},
    )
)
