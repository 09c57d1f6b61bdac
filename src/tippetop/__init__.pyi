from . import derivatives as derivatives
from . import errors as errors
from . import extending as extending
from . import friction as friction
from . import landscapes as landscapes
from . import theory as theory
from .errors import InputError as InputError
from .errors import Interrupted as Interrupted
from .errors import StoreError as StoreError
from .library.exchanging import compare as compare
from .library.exchanging import fit as fit
from .library.many import ensemble as ensemble
from .library.run import Run as Run
from .library.running import open as open
from .library.running import resume as resume
from .library.running import run as run
from .library.stored_run import StoredRun as StoredRun
from .mechanics.systems.cylinder import Cylinder as Cylinder
from .mechanics.systems.heavy_top import HeavyTop as HeavyTop
from .mechanics.systems.tippe_top import TippeTop as TippeTop
from .problem import Problem as Problem
from .runs.starting import load as load
from .scenario.reading import presets as presets
from .sweeps.sweep import sweep as sweep

__version__: str
