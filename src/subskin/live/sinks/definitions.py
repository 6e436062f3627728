"""The messages of subskin for ROS 2, and the one of others that ROS does not bring along.

The folder `ros2/subskin_msgs` of the repository holds the same text as files.
"""

from __future__ import annotations

__all__ = ["DEFINITIONS", "SLIP", "STATUS"]

CONTACT = """\
# What touched the skin in one frame, as subskin found it.
# Frame, right-handed: x into the skin, y along its surface, z across it; x = 0 is the surface.
# NaN: not known.

# status
uint8 OK=0
uint8 AMBIGUOUS=1        # another contact explains the readings nearly as well
uint8 NO_CONTACT=2
uint8 UNEXPLAINED=3      # no contact explains the readings
uint8 INCOMPLETE=4       # too few sensors could be used
uint8 NOT_SOUGHT=255

# slip
uint8 HOLDS=0
uint8 AT_RISK=1
uint8 SLIPS=2
uint8 CANNOT_TELL=3
uint8 NOT_ASKED=255

std_msgs/Header header
uint8 status
geometry_msgs/Point position      # where it presses [m]
geometry_msgs/Vector3 force       # on the skin [unit]: x presses in, y and z drag
string unit                       # "N"; "N/m" of a long contact: times length it is in N
float64 length                    # of a long contact [m]
float64 half_width                # of a long contact [m]
float64 beside                    # how far a point presses beside a row of sensors, |z| [m]
string[] covariance_of            # what the covariance is of: y and z of the position [m], n, ty and tz of the force
float64[] covariance              # row by row
float64 residual                  # chi-square
uint8 slip
float64 slip_ratio                # drag / (friction * normal force)
float64 slip_probability
int64 sequence                    # the device's number of the frame; -1 where it counts none
"""

EVENT = """\
# Something that happened: contact_on, contact_off, slip_risk, slip, overload, sensor_lost, gap, zeroed, ...
std_msgs/Header header
string kind
string text
string values                     # JSON
"""

TACTILE_STATE = """\
std_msgs/Header header
sensor_msgs/ChannelFloat32[] sensors
"""

DEFINITIONS = {
    "subskin_msgs/msg/Contact": CONTACT,
    "subskin_msgs/msg/Event": EVENT,
    "tactile_msgs/msg/TactileState": TACTILE_STATE,
}
"""Text of each message by its type."""

STATUS = {"ok": 0, "ambiguous": 1, "no_contact": 2, "unexplained": 3, "incomplete": 4, "": 255}
SLIP = {"holds": 0, "at_risk": 1, "slips": 2, "cannot_tell": 3, "": 255}
"""What a recording calls them, and what a message does."""
