"""How colcon installs the package."""

from setuptools import setup

setup(
    name="subskin_ros",
    version="0.2.0",
    packages=["subskin_ros"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/subskin_ros"]),
        ("share/subskin_ros", ["package.xml"]),
        ("share/subskin_ros/launch", ["launch/finger.launch.py"]),
    ],
    install_requires=["setuptools", "subskin[live]"],
    zip_safe=True,
    maintainer="The subskin developers",
    maintainer_email="subskin@example.org",
    description="Publishes what subskin finds in the readings of a tactile sensor.",
    license="MIT",
    entry_points={"console_scripts": ["finger = subskin_ros.node:main"]},
)
