"""Calibrations of simulated joints and cameras as drawn, and what is true of each of them."""

from dataclasses import asdict

from drivers.sim.camera.wiring import true_camera
from rig.assembly.simulated import install, make_plant
from rig.mechanisms.joint.calibration.board_lens import Board, read_views
from rig.mechanisms.joint.calibration.board_views import VIEWS, simulate_views
from rig.mechanisms.joint.calibration.parameters import LENGTHS

JOINT = (
    "simulation.perturbation.geometry=0.02",
    "simulation.perturbation.camera_position=2 mm",
    "simulation.perturbation.camera_angle=2 deg",
    "simulation.perturbation.camera_latency=5 ms",
    "simulation.perturbation.friction=0.3",
    # What `encoders` and `wires` leave of a rod's zero: with the wires' own 20 µm, which are
    # drawn anyway, a standard deviation of 50 µm.
    "simulation.perturbation.encoder_offset=84 µm",
)
LENS = (
    "simulation.perturbation.camera_focal=0.02",
    "simulation.perturbation.camera_centre=20",
    "simulation.perturbation.camera_distortion=0.1",
)
DRAWN = {
    "joint camera": JOINT,
    "joint geometry": (*JOINT, "simulation.perturbation.wire_offset=2 mm"),
    "joint lens": LENS,
}


def camera_of(profile):
    """Return the camera that the simulated joint has."""
    return true_camera(install(profile, make_plant(profile), "camera")[1])


def true_of_camera(profile, seed, procedure, folders):
    """Return where the camera is and how late, in the frame of the simulated joint."""
    camera = camera_of(profile)
    scene, optics = camera.scene, camera.optics
    true = {("camera", "latency"): scene.latency}
    for k, axis in enumerate("xyz"):
        place = scene.position_camera_in_base[k] + optics.position_error[k]
        true["camera", f"position.{axis}"] = place
        true["camera", f"angle.{axis}"] = optics.rotation_error[k]
    return true


def true_of_geometry(profile, seed, procedure, folders):
    """Return what the simulated joint was made to, beside its camera."""
    from drivers.sim.perturbation import draw, perturb_geometry

    draws = draw(asdict(profile.simulation.perturbation), seed)
    made = perturb_geometry(profile.nominal_settings.geometry, draws)
    true = {("joint", name): getattr(made, name) for name in LENGTHS}
    for k, angle in enumerate(made.anchor_angles, 1):
        true["joint", f"anchor_angle_{k}"] = angle
    true["joint", "home"] = profile.plant.settings.home + draws.wire_offset
    return true | true_of_camera(profile, seed, procedure, folders)


def true_of_lens(profile, seed, procedure, folders):
    """Return the lens that the simulated camera has."""
    lens = camera_of(profile).scene.intrinsics
    return {("camera", name): getattr(lens, name) for name in ("fx", "fy", "cx", "cy", "k1", "k2")}


def look_at_boards(lens, profile, out):
    """Return what a lens's procedure finds in simulated views, and where those are."""
    board = Board()
    folder = simulate_views(profile, "camera", board, out)
    return lens.identify(profile, read_views(folder / VIEWS, board), {}), [folder]


TRUE = {
    "joint camera": true_of_camera,
    "joint geometry": true_of_geometry,
    "joint lens": true_of_lens,
}
