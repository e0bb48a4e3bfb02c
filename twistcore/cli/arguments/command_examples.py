"""Examples for every command's --help; a test parses all of them and runs the cheap ones."""

from __future__ import annotations

from collections.abc import Mapping

EXAMPLES: Mapping[str, tuple[str, ...]] = {
    "info": (
        "twistcore info walk.bvh",
        "twistcore info walk.bvh run.bvh --json",
        "twistcore info walk.bvh --names",
        "twistcore info - < walk.bvh",
    ),
    "detect": (
        "twistcore detect walk.bvh --explain",
        "twistcore detect walk.bvh run.bvh --kinds limb-flip --fail-over 0",
        "twistcore detect walk.bvh --method paper --tau 5 --chain LeftForeArm --json",
    ),
    "signals": (
        "twistcore signals walk.bvh --csv walk.csv --chain LeftForeArm",
        "twistcore signals walk.bvh run.bvh --csv - --chain LeftArm",
    ),
    "refine": (
        "twistcore refine walk.bvh -o walk.clean.bvh --report report",
        "twistcore refine walk.bvh -o walk.clean.bvh --session walk.twist.json",
        "twistcore refine - -o - --min-confidence 0.9 < walk.bvh > walk.clean.bvh",
    ),
    "apply": (
        "twistcore apply walk.twist.json walk.bvh -o walk.clean.bvh",
        "twistcore apply reviewed captures -o corrected --workers 4",
    ),
    "report": (
        "twistcore report walk.twist.json -o pages --clip walk.bvh",
        "twistcore report out -o pages --pages 50 --no-pictures",
    ),
    "inject": ("twistcore inject walk.bvh -o bad.bvh --truth bad.truth.json --seed 1",),
    "evaluate": (
        "twistcore evaluate --truth bad.truth.json --clean walk.bvh --refined refined.bvh",
    ),
    "tune": (
        "twistcore tune captures -o rig.toml --workers 4",
        "twistcore tune captures -o rig.toml --verdicts --performer Kim",
    ),
    "benchmark": (
        "twistcore benchmark captures --protocol P0 H1 --methods detectors --json bench.json",
    ),
    "batch": (
        "twistcore batch captures -o out --refine --report",
        "twistcore batch 'takes/**/*_raw.bvh' @more.txt -o out --fail-if 'severity>5' --csv o.csv",
        "twistcore batch captures -o out-3 --shard 3/20",
    ),
    "diff": (
        "twistcore diff walk.bvh run.bvh",
        "twistcore diff delivery-1 delivery-2 --json",
        "twistcore refine walk.bvh -o - | twistcore diff walk.bvh -",
    ),
    "export": (
        "twistcore export walk.twist.json walk.bvh --script maya -o keys.py",
        "twistcore export walk.twist.json walk.bvh --script blender -o keys.py --dry-run",
    ),
    "convert": (
        "twistcore convert take.fbx -o take.bvh",
        "twistcore convert scene.glb -o dance.bvh --take Dance --blender /opt/blender/blender",
    ),
    "completion": (
        "twistcore completion bash > ~/.local/share/bash-completion/completions/twistcore",
        "twistcore completion zsh > ~/.zfunc/_twistcore",
        "twistcore completion fish > ~/.config/fish/completions/twistcore.fish",
    ),
    "quamo refine": (
        "twistcore quamo refine walk.bvh -o smooth.bvh",
        "twistcore quamo refine walk.bvh -o smooth.bvh --method spline --cutoff 5",
        "twistcore quamo refine poses.npz -o smooth.bvh --up z --fps 30",
    ),
    "quamo noise": ("twistcore quamo noise walk.bvh -o noisy.bvh --level B --seed 1",),
    "quamo evaluate": ("twistcore quamo evaluate cmu --weights assets/quamo --seeds 1",),
    "quamo ablation": ("twistcore quamo ablation cmu --weights assets/quamo --json",),
    "quamo train": ("twistcore quamo train cmu -o weights --hold-out 05 --epochs 10",),
}


def epilog(command: str) -> str:
    """The end of a command's help."""
    lines = EXAMPLES[command]
    head = "Example:" if len(lines) == 1 else "Examples:"
    return "\n".join([head, *(f"  {line}" for line in lines)])
