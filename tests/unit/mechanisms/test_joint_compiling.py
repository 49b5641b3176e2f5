"""What a joint's cycles call is compiled for a run, and not for a look at the profile."""

from joint_fakes import JointBench

from controllers.spherical_joint.forward import ForwardKinematics
from controllers.spherical_joint.tension import TensionDistribution


def test_it_is_compiled_when_a_controller_is_attached(monkeypatch):
    compiled = []
    for kind in (ForwardKinematics, TensionDistribution):
        monkeypatch.setattr(kind, "compile", lambda one: compiled.append(id(one)))
    bench = JointBench()
    assert compiled == []
    bench.joint.attach(None, None)
    assert len(set(compiled)) == 3  # the pose, the pose without one wire, the shares of tension
