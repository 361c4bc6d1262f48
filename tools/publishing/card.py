"""The card of a pretrained policy: training, results, failures, use."""

import json
import shlex
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass
from string import Template

from asddpg.command_line import train_config
from asddpg.config import TaskConfig, TrainConfig
from asddpg.episodes.evaluation import ROWS, EvaluationResult, cell
from asddpg.options.values import write_value
from tasks.gymnasium_api.navigation_env import id_and_scene
from tasks.options import options_of
from tasks.registry import ANYWHERE
from tools.experiments.tables import markdown
from tools.publishing.front_matter import RATES, front_matter

_CARD = Template("""\
# $name

A policy for `$task`, weights after step $step of $total_steps ($checkpoint).

## Training

```
$command
```

$circumstances

## Results

On $episodes stored test pairs, which training never sees, without noise; in brackets the 95 % interval. The metric is
−0.01 a step and +2 for reaching; the mean time is over the episodes that reached the goal.
$scene_note
$metrics
$elsewhere
## Failures

The actor alone. $failures

$limits

## Use

```
python -m asddpg.evaluate run=pretrained:$name
python -m asddpg.play run=pretrained:$name live=true     # watch it in Foxglove
```

```python
$snippet
```
""")

_SNIPPET = Template("""\
$imports
from asddpg.runs.pretrained import load_policy

policy = load_policy("$name")
environment = $environment
observation, info = environment.reset(seed=0)
terminated = truncated = False
while not (terminated or truncated):
    observation, reward, terminated, truncated, info = environment.step(policy.act(observation))
print(info["outcome"])""")

DRIVERS = {
    "actor": "actor alone",
    "switch": "actor and controller, `driver=switch`",
    "controller": "controller alone",
}


@dataclass(frozen=True)
class Facts:
    """Contents of a card."""

    name: str
    config: TrainConfig
    checkpoint: str  # last or best
    step: int  # of the weights
    seconds: float  # of the training
    note: str  # how the seed was chosen; may be empty
    provenance: Mapping[str, str]  # versions and scene of the training
    tested_scene: str  # hash
    metrics: dict[str, EvaluationResult]  # by driver, as in DRIVERS
    failures: str  # Markdown
    elsewhere: str = ""  # where a policy of changing rooms drives, Markdown


def card(facts: Facts) -> str:
    """The card, Markdown."""
    config = facts.config
    chosen = "`last`" if facts.checkpoint == "last" else "`best`, where validation while training was best"
    rates = {rate: getattr(facts.metrics["actor"], rate).value for rate in RATES}
    return front_matter(facts.name, config.task.name, rates) + _CARD.substitute(
        name=facts.name,
        task=config.task.name,
        step=facts.step,
        total_steps=config.total_steps,
        checkpoint=chosen,
        command=shlex.join(["python", "-m", "asddpg.train", *arguments_of(config)]),
        circumstances=_circumstances(facts),
        episodes=next(iter(facts.metrics.values())).episodes,
        scene_note=_scene_note(facts),
        metrics=_metrics_table(facts.metrics),
        elsewhere=f"\n{facts.elsewhere}\n" if facts.elsewhere else "",
        failures=facts.failures,
        limits=_limits(config),
        snippet=_snippet(facts.name, config.task),
    )


def arguments_of(config: TrainConfig) -> list[str]:
    """The arguments that make a configuration, but for the run's folder: train_config's inverse.

    They are the task, then the choices and the options that differ from the task's defaults.

    Raises:
        UserError: no arguments of this version make that configuration.
    """
    arguments = [f"task={config.task.name}"]
    presets = train_config(arguments)
    for group in ("agent", "reward", "network"):
        name = getattr(config, group).name
        if name != getattr(presets, group).name:
            arguments.append(f"{group}={name}")
    defaults = {option.name: option.value for option in options_of(train_config(arguments))}
    values = {option.name: option.value for option in options_of(config) if option.name != "run_dir"}
    return arguments + [f"{name}={write_value(value)}" for name, value in values.items() if value != defaults[name]]


def _circumstances(facts: Facts) -> str:
    versions = ", ".join(f"{name} {version}" for name, version in facts.provenance.items() if name != "model_hash")
    text = (
        f"Seed {facts.config.seed}, {facts.seconds / 60:.1f} minutes on {facts.config.device}; scene "
        f"{facts.provenance['model_hash']}. With {versions}. On one machine with the same versions the command gives "
        "the same weights again."
    )
    return "\n\n".join(_wrapped(part) for part in (text, facts.note) if part)


def _scene_note(facts: Facts) -> str:
    if facts.tested_scene == facts.provenance["model_hash"]:
        return ""
    return f"The scene has changed since the training: these results are of {facts.tested_scene}.\n"


def _metrics_table(metrics: dict[str, EvaluationResult]) -> str:
    columns = metrics.values()
    rows = [
        [title, *(cell(getattr(column, field), form) for column in columns)] for field, (title, form) in ROWS.items()
    ]
    rows.append(["controller's share of the steps", *(f"{column.controller_share:.3f}" for column in columns)])
    return markdown(["", *(DRIVERS[name] for name in metrics)], rows)


def _limits(config: TrainConfig) -> str:
    laser = config.task.laser
    is_perfect = not (laser.noise or laser.dropout or laser.latency)
    noise = f"noise {laser.noise:g}, lost returns {laser.dropout:g}, latency {laser.latency:g} s"
    kind = "without noise, lost returns or latency" if is_perfect else f"with {noise}"
    rooms = "in generated rooms, none in both" if config.task.name == ANYWHERE else "in this one room"
    unknown = "" if config.task.name == ANYWHERE else "in another room, "
    return _wrapped(
        f"Trained and tested {rooms}, with a laser of {laser.num_beams} beams over {laser.field_of_view:g}° "
        f"{kind}; nothing here says how it drives {unknown}among things that move by themselves, or on a real "
        "robot."
    )


def _wrapped(text: str) -> str:
    return textwrap.fill(text, 120, break_long_words=False, break_on_hyphens=False)


def _snippet(name: str, task: TaskConfig) -> str:
    if task == TaskConfig(name=task.name):
        imports = "import gymnasium\nimport tasks  # registers the environments"
        environment_id, scene = id_and_scene(task.name)
        scene_argument = "".join(f", {name}={json.dumps(value)}" for name, value in scene.items())
        environment = f'gymnasium.make("{environment_id}"{scene_argument})'
    else:
        imports = "from asddpg.build import make_environment"
        environment = "make_environment(policy.config.task, policy.config.reward)"
    return _SNIPPET.substitute(name=name, imports=imports, environment=environment)
