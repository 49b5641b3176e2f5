"""Metrics and timing of a run that has ended, as far as it was recorded."""

from rig.experiment.ending import Ending
from rig.experiment.metrics import Metric, evaluate
from rig.experiment.new_folder import write_evaluation
from rig.experiment.plan import Plan, constants_of
from rig.experiment.stopwatch import Stopwatch
from rig.experiment.windows import MetricError
from rig.hal import ContractBroken, RigError
from rig.run_facts import RunStatus
from rig.run_folder import RunFolder, RunFolderError
from rig.runtime.log import LogError
from rig.runtime.log_columns import LogColumns, read_columns


def write_results(
    plan: Plan, folder: RunFolder, ending: Ending, stopwatch: Stopwatch
) -> tuple[list[Metric], list[RigError], Ending]:
    """Write metrics and timing of whatever was recorded.

    Returns
    -------
    metrics : list of Metric
        Those that could be computed.
    unmeasured : list of RigError
        What the plan's own measures failed by.
    ending : Ending
        Of a run that could or could not be written down.
    """
    from rig.report.timing import summarise_timing

    metrics: list[Metric] = []
    unmeasured: list[RigError] = []
    if not folder.log_path.exists():
        return metrics, unmeasured, ending
    try:
        log = read_columns(folder.log_path)
        if plan.motion.watches:  # what it came to is known only now
            write_evaluation(plan, folder)
        if len(log.cycle):
            folder.write_timing({**summarise_timing(log), **stopwatch.facts})
        if ending.status is RunStatus.OK:
            metrics, unmeasured = _measure(plan, log)
            folder.write_metrics(metrics)
    except (RunFolderError, LogError) as error:
        return metrics, unmeasured, ending.losing(str(error))
    return metrics, unmeasured, ending


def _measure(plan: Plan, log: LogColumns) -> tuple[list[Metric], list[RigError]]:
    """Compute the metrics; return them, and what those of the plan's own measures failed by."""
    mechanism, motion = plan.profile.mechanism, plan.motion
    wanted = plan.experiment.metrics
    own = {name: spec for name, spec in wanted.items() if spec.measure in plan.measures}
    installed = {name: spec for name, spec in wanted.items() if name not in own}
    constants = constants_of(plan.profile)
    metrics = evaluate(
        log, motion.segments, installed, motion.facts, mechanism, constants=constants
    )
    unmeasured: list[RigError] = []
    for name, spec in own.items():
        try:
            metrics += evaluate(log, motion.segments, {name: spec}, measures=plan.measures)
        except (MetricError, ContractBroken) as error:
            unmeasured.append(error)
    return metrics, unmeasured
