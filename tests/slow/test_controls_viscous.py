"""What must be so of viscous flows, though no reference says how much."""

from __future__ import annotations

from debrisflow.validation.viscous import start_up, taylor_green


def test_the_poiseuille_profile_converges():
    flow, index = start_up.POISEUILLE, start_up.TIMES.index(0.5)
    errors = []
    for rows in (10, 20):
        y, u = start_up.profiles(flow, rows, start_up.SLOW)[index]
        errors.append(abs(u - flow.profile(y, 0.5)).max())
    assert errors[1] < 0.5 * errors[0]


def test_the_lattice_of_the_start_costs_vortices_their_energy():
    # the cause that is given for a decay that is too fast
    ordered, stirred = (taylor_green.run(40, 100.0, is_stirred) for is_stirred in (False, True))
    assert ordered.viscosity > stirred.viscosity + 0.1
