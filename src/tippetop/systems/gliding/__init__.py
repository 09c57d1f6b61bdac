"""A rigid body of revolution that glides on a plane: contact arm a = c*3hat - R*zhat, F = g_n*zhat - k g_n v_A.

c = alpha*R is the tippe top; R = 0, c = -l the gliding heavy top. Equation numbers are those of the source,
Rutstam (2010), where its misprints are corrected; phi is the azimuth of the horizontal projection of 3hat.
Every formula takes its parameters as a `Body`, in any consistent units. `body` has the functions of the state that
do not depend on the form, `vector` and `euler` the two forms, `chart` what joins them, `names` what people read.
"""

from .body import Body as Body
from .body import Scalars as Scalars
from .body import arm2 as arm2
from .body import arm_speed2 as arm_speed2
from .body import body_units as body_units
from .body import energy as energy
from .body import friction_loss as friction_loss
from .body import friction_power as friction_power
from .body import g_n as g_n
from .body import height_energy as height_energy
from .body import jellett as jellett
from .body import modified_energy as modified_energy
from .body import modified_energy_rate as modified_energy_rate
from .body import rolling_velocity as rolling_velocity
from .body import rotation_energy as rotation_energy
from .body import torque_free as torque_free
from .body import vertical_inertia as vertical_inertia
from .body import vertical_potential as vertical_potential
from .body import yielding as yielding
from .chart import angles_of_euler as angles_of_euler
from .chart import angles_of_vector as angles_of_vector
from .chart import axis_and_momentum as axis_and_momentum
from .chart import axis_angles as axis_angles
from .chart import euler_of_angles as euler_of_angles
from .chart import gliding_angles as gliding_angles
from .chart import vector_of_angles as vector_of_angles
from .euler import EULER_UNITS as EULER_UNITS
from .euler import EulerState as EulerState
from .euler import centre_velocity as centre_velocity
from .euler import euler_rates as euler_rates
from .euler import euler_scalars as euler_scalars
from .names import COS_INVERTED as COS_INVERTED
from .names import ENERGIES as ENERGIES
from .names import EQUATOR as EQUATOR
from .names import EULER as EULER
from .names import EVENTS as EVENTS
from .names import FALLEN as FALLEN
from .names import FORMS as FORMS
from .names import INITIAL as INITIAL
from .names import INVERTED as INVERTED
from .names import JAMMED as JAMMED
from .names import JELLETT_QUANTITY as JELLETT_QUANTITY
from .names import LIFTOFF as LIFTOFF
from .names import LONG_NAMES as LONG_NAMES
from .names import POLE as POLE
from .names import QUANTITIES as QUANTITIES
from .names import SETTLED as SETTLED
from .names import TURNING as TURNING
from .names import VECTOR as VECTOR
from .names import VECTORS as VECTORS
from .names import away_from_pole as away_from_pole
from .names import equator as equator
from .names import given_angles as given_angles
from .names import near_inversion as near_inversion
from .names import sliding as sliding
from .names import start as start
from .names import turning as turning
from .vector import QUADRATURES as QUADRATURES
from .vector import VECTOR_UNITS as VECTOR_UNITS
from .vector import VectorState as VectorState
from .vector import angular_velocity as angular_velocity
from .vector import axis as axis
from .vector import axis_rate as axis_rate
from .vector import contact_velocity as contact_velocity
from .vector import momentum as momentum
from .vector import torque_free_fall as torque_free_fall
from .vector import vector_rates as vector_rates
from .vector import vector_scalars as vector_scalars
