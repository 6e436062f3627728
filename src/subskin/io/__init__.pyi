from ._recorded import LiveFormat
from .body_file import read_body
from .changed import fit_held, with_calibration, with_orientation, with_relaxation
from .finger_file import FingerFile, load, parse_finger, save_finger
from .goals_file import GoalsFile, finger_text, load_goals, parse_goals
from .kept_arrays import FolderStore
from .tables import Table, TableReader, TableWriter, read_table, reading, write_table, writing
from .touch_store import TouchesCost, cost_of_touches, save_touches, shards_done, write_touches
from .touches_file import TouchesFile, load_touches, parse_touches
from .units import format_quantity, quantity

__all__ = [
    "FingerFile",
    "FolderStore",
    "GoalsFile",
    "LiveFormat",
    "Table",
    "TableReader",
    "TableWriter",
    "TouchesCost",
    "TouchesFile",
    "cost_of_touches",
    "finger_text",
    "fit_held",
    "format_quantity",
    "load",
    "load_goals",
    "load_touches",
    "parse_finger",
    "parse_goals",
    "parse_touches",
    "quantity",
    "read_body",
    "read_table",
    "reading",
    "save_finger",
    "save_touches",
    "shards_done",
    "with_calibration",
    "with_orientation",
    "with_relaxation",
    "write_table",
    "write_touches",
    "writing",
]
