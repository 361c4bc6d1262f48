"""Invalid command lines, with all that can be wrong with them, for property-based tests."""

from collections.abc import Sequence
from typing import Any

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from asddpg.command_line import GROUPS
from asddpg.config import EvaluateConfig, TrainConfig
from asddpg.options.values import write_value
from tests.support.option_values import ArgumentLists, base, is_optional, options, rules, values_of

# Values that fit no option of a type.
MISFITS: dict[Any, Sequence[str]] = {
    int: ("abc", "1.5", "1e3", "true", "null", "[1]", "{a:1}", "1 2", "0x10", "'1'", "☃", "٣", "nan", "--1", "1;2"),
    float: ("abc", "true", "null", "[0.5]", "{a:1}", "1 2", "½", "'0.5'", "0,5", "1e", "⅓"),
    bool: ("maybe", "2", "0.5", "null", "[true]", "{a:true}", "wahr", "-1"),
    str: ("a\nb", "\x1b[31ma", "a\tb", "\x7f"),
    list[int]: ("abc", "null", "[a,b]", "[1.5,2]", "[[1],2]", "[1,null]", "{a:1}", "[1,", "1,,2", "[true,2]"),
    list[float]: ("abc", "null", "[a,b]", "[[1],2]", "[1,null]", "{a:1}", "[1.0,", "[nan,x]"),
    list[str]: ("null", "[[a]]", "[{a:b}]", "{a:b}", "[a,", "[null]"),
}
# Forms of a name that are an option to Hydra.
SYNTAX = ("+{}", "++{}", "~{}", "-{}", "--{}", "{}@x", "{}@a:b", "{}/x", "{}.x", "hydra.{}", " {}", "{} ", "{}[0]")
REFERENCES = (
    *("${seed}", "${oc.env:HOME}", "${oc.env:HOME,/tmp}", "${now:%Y}", "${hydra:runtime.cwd}", "${oc.decode:1}"),
    *("a${agent.name}", "'${oc.env:HOME}'", "[${seed},1]", "${", "${${seed}}", "${oc.create:{a:1}}"),
)
BROKEN = (
    *("", " ", "=", "==", "=3", "seed", "task", "seed==1", "seed=[1", "seed={", "seed=(1", "seed='1", 'seed="'),
    *("seed=]", "seed:1", "seed = 1", "seed=1\nseed=2", "\x1b[31m", "-h=", "-", "-m", "--multirun", "--cfg=job"),
    "--config-dir=/etc",
)
IMPOSSIBLE_FOLDERS = (
    *("a_file", "a_file/below", "full", "..", "/", "/dev/null", "/dev/null/x", "/proc/x", "/etc", "a" * 300),
)
CONTRADICTIONS = (
    *("agent.assisted=false", "agent.learning_starts=100001"),
    "agent.target_noise=0.1 agent.critic_follows_switch=true",
    *("agent=ddpg agent.imitation=1", "agent=ddpg agent.balanced_batches=true", "agent=ddpg agent.charge_critic=true"),
    *("agent=astd3 agent.critic_follows_switch=true", "agent.withdrawal.begin=0.95", "agent.withdrawal.end=0.05"),
    "agent.batch_size=2000 agent.buffer_size=1999 agent.learning_starts=5",
    "agent.balanced_batches=true agent.batch_size=1",
    *("record.cameras=[chase] record.every=0", "record.cameras=[nosuch]", "record.cameras=[chase,../chase]"),
    *("task.min_linear_velocity=0.5", "task.min_linear_velocity=0.3 task.max_linear_velocity=0.2"),
    "network.widths=[65536,65536,65536,65536]",
    "task.num_scans=100 task.laser.num_beams=2000 agent.buffer_size=10000000",
)
DRIVE = "agent=controller task=nav_empty"
INVALID_DRIVERS = (
    *("", "run=nowhere", "run=a_file", "run=full", "run=/proc/self", "run=" + "a" * 300, "run=läufe"),
    *("run=pretrained:", "run=pretrained:nowhere", "run=pretrained:../nav_empty", "agent=pilot", "agent=controller"),
    *("agent=controller task=nav_foo", "agent=random task=nav_empty run=x", f"{DRIVE} driver=switch"),
    *("run=x controller.gains=[1,2]", "agent=random task=nav_empty checkpoint=best"),
    *("run=pretrained:nav_empty checkpoint=best", "run=pretrained:nav_empty task=nav_foo"),
)
INVALID_EVALUATIONS = (f"{DRIVE} episodes=201", f"{DRIVE} record.cameras=[chase]")
INVALID_PLAYS = (
    *(f"{DRIVE} video=x.avi", f"{DRIVE} video=nowhere/x.mp4"),
    *(f"{DRIVE} video=x.mp4 camera=nosuch", f"{DRIVE} camera=top"),
)
CONTROLLERS = ("nowhere:No", "os:path", "os:getcwd", "builtins:dict", "builtins:int", ":", "a:", ":a", "..:a")
DEVICES = ("tpu", "CPU", "cuda:x", "cuda:-1", "cpu:", "cpu:1", "cuda:²", "mps", f"cuda:{10**20}", "cuda 0", "läufer")


def invalid_arguments(config: type) -> ArgumentLists:
    """A command line with one invalid argument, and valid ones before or after it."""
    kinds = [_unknown(config), _misspelt(config), _misfits(config), _out_of_range(config), _not_finite(config)]
    kinds += [_too_large(config), _empty(config), _with_syntax(config), _references(config), _broken()]
    kinds += [_of_options(config, "device", DEVICES), _of_options(config, "controller.type", CONTROLLERS)]
    if config is TrainConfig:
        kinds += [_no_choice(), st.sampled_from(CONTRADICTIONS).map(str.split)]
        kinds += [_of_options(config, "run_dir", IMPOSSIBLE_FOLDERS)]
    else:
        own = INVALID_EVALUATIONS if config is EvaluateConfig else INVALID_PLAYS
        kinds += [st.sampled_from([*INVALID_DRIVERS, *own]).map(str.split)]
    right = st.sampled_from([[], [], ["device=cpu"], ["controller.gains=[2,1]"]])
    return st.builds(_beside, st.one_of(kinds), right, st.booleans())


def _beside(invalid: Sequence[str], valid: Sequence[str], is_before: bool) -> list[str]:
    # Of two arguments for one option the last would count.
    others = [argument for argument in valid if not any(argument.split("=")[0] in each for each in invalid)]
    return [*others, *invalid] if is_before else [*invalid, *others]


def _of_options(config: type, name: str, values: Sequence[str]) -> ArgumentLists:
    driven = [] if config is TrainConfig else ["agent=controller", "task=nav_empty"]
    return st.sampled_from(values).map(lambda value: [*driven, f"{name}={value}"])


def _name(config: type) -> SearchStrategy[str]:
    return st.sampled_from(sorted(options(config)))


def _unknown(config: type) -> ArgumentLists:
    known = {*options(config), *(GROUPS if config is TrainConfig else ())}
    plain = st.from_regex(r"[a-z_][a-z0-9_]{0,12}(\.[a-z_]{1,9}){0,2}", fullmatch=True)
    names = st.one_of(plain, st.text(min_size=1, max_size=12)).filter(lambda name: name not in known)
    # An equals sign ends a name.
    names = names.filter(lambda name: "=" not in name and "\0" not in name)
    return st.tuples(names, st.sampled_from(["1", "0.5", "true", "a", "[1]"])).map(lambda each: ["=".join(each)])


def _misspelt(config: type) -> ArgumentLists:
    def misspell(name: str, place: int, how: int) -> str:
        place %= len(name)
        return (name[:place] + name[place + 1 :], name[:place] + "x" + name[place:], name.upper())[how]

    built = st.builds(misspell, _name(config), st.integers(0, 40), st.integers(0, 2))
    return built.filter(lambda name: name not in options(config)).map(lambda name: [f"{name}=1"])


def _misfits(config: type) -> ArgumentLists:
    def misfit(name: str, number: int) -> list[str]:
        kind = options(config)[name]
        values = [each for each in MISFITS[base(kind)] if not (each == "null" and is_optional(kind))]
        return [f"{name}={values[number % len(values)]}"]

    return st.builds(misfit, _name(config), st.integers(0, 100))


def _out_of_range(config: type) -> ArgumentLists:
    def invalid(name: str) -> SearchStrategy[str]:
        is_right = rules(config)[name]
        return values_of(base(options(config)[name])).filter(lambda value: not is_right(value)).map(write_value)

    return st.sampled_from(sorted(rules(config))).flatmap(
        lambda name: invalid(name).map(lambda value: [f"{name}={value}"])
    )


def _not_finite(config: type) -> ArgumentLists:
    floats = sorted(name for name, kind in options(config).items() if kind is float)
    arguments = [f"{name}={value}" for name in floats for value in ("nan", "inf", "-inf", "1e999")]
    arguments += [f"controller.gains={value}" for value in ("[nan,1]", "[1,inf]", "[-inf,nan]", "[1e999,1]")]
    return st.sampled_from(arguments).map(lambda argument: [argument])


def _too_large(config: type) -> ArgumentLists:
    numbers = sorted(name for name, kind in options(config).items() if base(kind) in (int, float, list[int]))
    digits = st.sampled_from([20, 30, 309, 400, 4299, 4301, 9000])

    def argument(name: str, count: int, sign: str) -> list[str]:
        count = max(count, 309) if options(config)[name] is float else count
        number = f"{sign}1{'0' * count}"
        return [f"{name}=[{number},1]" if options(config)[name] == list[int] else f"{name}={number}"]

    return st.builds(argument, st.sampled_from(numbers), digits, st.sampled_from(["", "-"]))


def _empty(config: type) -> ArgumentLists:
    return _name(config).map(lambda name: [f"{name}="])


def _with_syntax(config: type) -> ArgumentLists:
    value = st.sampled_from(["", "=1", "=a"])
    return st.builds(
        lambda form, name, value: [form.format(name) + value], st.sampled_from(SYNTAX), _name(config), value
    )


def _references(config: type) -> ArgumentLists:
    names = _name(config).filter(lambda name: name != "run_dir")  # which may be any text
    return st.builds(lambda name, value: [f"{name}={value}"], names, st.sampled_from(REFERENCES))


def _broken() -> ArgumentLists:
    nested = st.builds(lambda depth, pair: [f"seed={pair[0] * depth}1{pair[1] * depth}"], st.integers(1, 400), _PAIRS)
    noise = st.text(st.characters(exclude_characters="\0"), max_size=20).filter(lambda argument: "=" not in argument)
    noise = noise.filter(lambda argument: argument not in ("-h", "--help"))
    return st.one_of(
        st.sampled_from(BROKEN).map(lambda argument: [argument]), nested, noise.map(lambda argument: [argument])
    )


_PAIRS = st.sampled_from([("[", "]"), ("{a:", "}"), ("[", ""), ("(", ")")])


def _no_choice() -> ArgumentLists:
    values = st.one_of(
        st.text(max_size=9), st.sampled_from(["", "null", "[nav_empty]", "{a:b}", "NAV_EMPTY", "nav_empty,x"])
    )

    def is_no_choice(each: tuple[str, str]) -> bool:
        return "\0" not in each[1] and each[1].strip(" '\"\t\n\r") not in GROUPS[each[0]]

    arguments = st.tuples(st.sampled_from(sorted(GROUPS)), values).filter(is_no_choice)
    return arguments.map(lambda each: ["=".join(each)])
