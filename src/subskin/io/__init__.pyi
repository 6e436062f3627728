from .finger_file import FingerFile, load, parse_finger, save_finger
from .goals_file import GoalsFile, finger_text, load_goals, parse_goals
from .search_store import FolderStore
from .tables import Table, read_table, write_table
from .units import format_quantity, quantity

__all__ = [
    "FingerFile",
    "FolderStore",
    "GoalsFile",
    "Table",
    "finger_text",
    "format_quantity",
    "load",
    "load_goals",
    "parse_finger",
    "parse_goals",
    "quantity",
    "read_table",
    "save_finger",
    "write_table",
]
