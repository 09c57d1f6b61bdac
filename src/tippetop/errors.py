"""What goes wrong in ways that the user can mend: each error is one or more sentences."""


class Interrupted(Exception):
    """The run was asked to stop, and stopped at a commit: its store can be resumed."""


class StoreError(OSError):
    """The store or the disk: one sentence, exit code 5."""


class InputError(ValueError):
    """A scenario that cannot be run; `sentences` says each thing that must hold and what was found."""

    def __init__(self, sentences: list[str]):
        super().__init__("\n".join(sentences))
        self.sentences = sentences


class Unfinished(Exception):
    """A sweep ended without some of its chunks; `sentences` names them. Begun again, it tries them again."""

    def __init__(self, sentences: list[str]):
        super().__init__("\n".join(sentences))
        self.sentences = sentences
