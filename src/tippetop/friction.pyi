from .mechanics.friction import Contensou as Contensou
from .mechanics.friction import Coulomb as Coulomb
from .mechanics.friction import Frictionless as Frictionless
from .mechanics.friction import Latitude as Latitude
from .mechanics.friction import Mixed as Mixed
from .mechanics.friction import Stribeck as Stribeck
from .mechanics.friction import Viscous as Viscous
from .mechanics.systems.cylinder import Modified as Modified
