from ._live import LiveFormat
from .body_file import read_body
from .finger_file import FingerFile, load, parse_finger, save_finger
from .goals_file import GoalsFile, finger_text, load_goals, parse_goals
from .search_store import FolderStore
from .tables import Table, TableReader, TableWriter, read_table, reading, write_table, writing
from .units import format_quantity, quantity

__all__ = [
    "FingerFile",
    "FolderStore",
    "GoalsFile",
    "LiveFormat",
    "Table",
    "TableReader",
    "TableWriter",
    "finger_text",
    "format_quantity",
    "load",
    "load_goals",
    "parse_finger",
    "parse_goals",
    "quantity",
    "read_body",
    "read_table",
    "reading",
    "save_finger",
    "write_table",
    "writing",
]
