"""Named cases for developers of contact simulators: exact references as files, and a score."""

from .export import export
from .named_cases import Case, case, names


__all__ = ["Case", "case", "export", "names"]
