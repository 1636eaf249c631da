// The files of the workspaces that the tests open.

const GLIDER = `# State of a glider

uint64 timestamp     # [us] Time since system start

uint8 PHASE_TOW = 0  # Behind a tow plane
uint8 PHASE_FREE = 1 # Released
uint8 phase          # [@enum PHASE] Flight phase
float32 sink         # [m/s] [@range -5, 20] Sink rate in air “at 𝟎 °C”
Wind[2] winds        # Wind at both wing tips

# TOPICS glider glider_backup
`;

const WIND = `# Wind over ground

uint64 timestamp  # [us] Time since system start
float32 speed     # [m/s] [@range 0, 60] [@invalid NaN] Wind speed
`;

const TOW = `# State of a tow plane

uint32 MESSAGE_VERSION = 1  # Version of the fields

uint64 timestamp  # [us] Time since system start
uint8 phase       # [@enum Glider.PHASE] Flight phase of the glider
`;

const CODES = `# Codes of a fleet

## Warnings (codes 64-127)

| Code | Abbr   | Description |
|-----:|--------|-------------|
|   64 | LOWBAT | Battery low; otherwise use code 130. |

## Errors (codes 128-191)

| Code | Abbr   | Description |
|-----:|--------|-------------|
|  130 | LOWBAT | Battery critical; otherwise use code 64. |
`;

const CONFIGURATION = `[[package]]
name = "gliders"
dialect = "px4"
include = ["msg/*.msg"]

[[package]]
name = "codes"
dialect = "table"
include = ["pages/*.md"]
`;

const PLANE = `# A plane

wing_msgs/Flap[<=4] flaps  # Flaps, from left to right
string name "α"            # Name
`;

const TRIM = `# Trims a plane

wing_msgs/Flap flap  # The flap to move
---
bool success         # True if it moved
`;

export const PX4 = { "msg/Glider.msg": GLIDER, "msg/Tow.msg": TOW, "msg/Wind.msg": WIND };

export const CONFIGURED = { ...PX4, "pages/codes.md": CODES, "uavspec.toml": CONFIGURATION };

export const ROS2 = {
  "src/wing_msgs/package.xml": "<package format='3'><name>wing_msgs</name></package>\n",
  "src/wing_msgs/msg/Flap.msg": "# A flap\n\nfloat32 angle  # [rad] Deflection\n",
  "src/plane_msgs/package.xml": "<package format='3'><name>plane_msgs</name></package>\n",
  "src/plane_msgs/msg/Plane.msg": PLANE,
  "src/plane_msgs/srv/Trim.srv": TRIM,
};
