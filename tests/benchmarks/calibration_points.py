"""A calibration as a point of a sweep: its estimates and what is true, as metrics."""

from calibration_truth import calibrate

from rig.sweeping.each import run_each


class Estimate:
    """What a calibration says of a quantity."""

    def __init__(self, value, low, high, std):
        self.value, self.low, self.high, self.std = value, low, high, std


def perform(job):
    """Calibrate as a job's options say: the procedure, and the seed."""
    procedure, seed = job.options
    metrics = []
    for name, estimate, true in calibrate(procedure, int(seed), job.logs):
        numbers = (estimate.value, estimate.low, estimate.high, estimate.std, true)
        metrics += [
            {"name": name, "value": float(number), "unit": "", "bound": None, "kind": None}
            for number in numbers
        ]
    return {"point": job.name, "status": "ok", "reason": "", "metrics": metrics}


def calibrate_each(procedure, seeds, folder, workers):
    """Return (name, estimate, true value) of each quantity of each seed."""
    cases = [(procedure, str(seed)) for seed in seeds]
    rows = []
    for finding in run_each("calibration_points:perform", cases, folder, workers):
        assert finding["status"] == "ok", finding["reason"]
        metrics = finding["metrics"]
        for first in range(0, len(metrics), 5):
            *estimate, true = (metric["value"] for metric in metrics[first : first + 5])
            rows.append((metrics[first]["name"], Estimate(*estimate), true))
    return rows
