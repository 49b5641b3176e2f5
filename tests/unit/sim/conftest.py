import pytest
from emulated_rig import Bench


@pytest.fixture
def bench():
    return Bench()
