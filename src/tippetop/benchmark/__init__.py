"""Named cases for developers of contact simulators: exact references as files, and a score."""

from .case_files import export
from .named_cases import Case, case, names
from .score import Score, score


__all__ = ["Case", "Score", "case", "export", "names", "score"]
