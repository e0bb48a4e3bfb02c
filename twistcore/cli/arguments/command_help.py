"""Define the help of every command: a summary, a description, and examples that the tests run."""

from __future__ import annotations

import argparse
from collections.abc import Mapping

from twistcore.work.frozen import dataclass


class HelpFormatter(argparse.HelpFormatter):
    """A help formatter that wraps paragraphs but keeps the lines of examples."""

    def add_argument(self, action: argparse.Action) -> None:
        """Add an argument to the help, with a wider first column for subcommands."""
        super().add_argument(action)
        if isinstance(action, argparse._SubParsersAction):
            self._action_max_length += self._indent_increment

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return "\n\n".join(
            part if "\n  " in part else super(HelpFormatter, self)._fill_text(part, width, indent)
            for part in text.split("\n\n")
        )


@dataclass(frozen=True)
class CommandHelp:
    """The parts of the help of one command.

    Attributes
    ----------
    summary
        A line for the list of commands, without a full stop.
    about
        Sentences after the summary.
    examples
        Command lines.
    note
        Sentences after the options, such as exit codes.
    """

    summary: str
    about: str = ""
    examples: tuple[str, ...] = ()
    note: str = ""

    @property
    def description(self) -> str:
        """Return the text before the options."""
        sentence = f"{self.summary[:1].upper()}{self.summary[1:]}."
        return f"{sentence}\n\n{self.about}" if self.about else sentence

    @property
    def epilog(self) -> str:
        """Return the text after the options."""
        head = "Example:" if len(self.examples) == 1 else "Examples:"
        lines = [head, *(f"  {line}" for line in self.examples)] if self.examples else []
        return "\n\n".join(filter(None, (self.note, "\n".join(lines))))


PROGRAM = CommandHelp(
    "find and remove axial twist errors in motion capture",
    "Every command has its own options and examples: twistcore help COMMAND.",
    (
        "twistcore info walk.bvh",
        "twistcore detect walk.bvh --explain",
        "twistcore refine walk.bvh -o walk.clean.bvh",
        "twistcore help detect",
    ),
    "Exit code: 0 done; 1 finished, but something could not be processed (listed); 2 wrong usage "
    "or unreadable input.",
)

# In the order in which `twistcore --help` lists them.
COMMANDS: Mapping[str, CommandHelp] = {
    "info": CommandHelp(
        "show the frames, joints, chains and limbs of clips",
        "One clip is shown in full, several clips as one row each. The first column of the chains "
        "and limbs lists the names for --chain.",
        (
            "twistcore info walk.bvh",
            "twistcore info walk.bvh run.bvh --json",
            "twistcore info walk.bvh --names",
            "twistcore info - < walk.bvh",
        ),
    ),
    "detect": CommandHelp(
        "list the intervals with errors",
        "Each line is one interval: chain, start, stop, offset δ and confidence. Frames "
        "are counted from 0, and stop is the first frame after the interval: 20 – 27 "
        "means frames 20 to 26. Text, JSON and CSV contain the same numbers. 'open' "
        "means that one side or one joint is uncertain.",
        (
            "twistcore detect walk.bvh --explain",
            "twistcore detect walk.bvh run.bvh --kinds limb-flip --fail-over 0",
            "twistcore detect walk.bvh --method paper --tau 5 --chain LeftForeArm --json",
            "twistcore detect walk.bvh --reference run.bvh",
        ),
    ),
    "signals": CommandHelp(
        "write the curves in which errors are detected, as CSV or JSON",
        "For each chain and frame: the parent's twist θp, the child's azimuth θc, their "
        "increments, the strength m and two reliabilities. Angles are in degrees.",
        (
            "twistcore signals walk.bvh --csv walk.csv --chain LeftForeArm",
            "twistcore signals walk.bvh run.bvh --csv - --chain LeftArm",
            "twistcore signals walk.bvh --csv walk.csv --method consistency",
        ),
    ),
    "diff": CommandHelp(
        "show the differences between two clips, two folders, two reviews or two reports",
        "For each joint: the frames in which its rotation differs, and by how much. A stop is the "
        "first frame after the difference. For two sessions of the same clip: how far the "
        "reviewers agree, and each interval on which they do not. For two reports of a clip: the "
        "intervals that are new, gone or decided differently. A difference is not an error: the "
        "exit code is 0.",
        (
            "twistcore diff walk.bvh run.bvh",
            "twistcore diff delivery-1 delivery-2 --json",
            "twistcore diff ada.twist.json ben.twist.json --merge both.twist.json",
            "twistcore refine walk.bvh -o - | twistcore diff walk.bvh -",
        ),
    ),
    "refine": CommandHelp(
        "write a corrected clip",
        "Corrects the intervals that are certain enough, counts the other intervals, and keeps the "
        "rest of the clip byte for byte. To judge the other intervals, open the clip or the "
        "session in the window: twist-inspector CLIP.",
        (
            "twistcore refine walk.bvh -o walk.clean.bvh --report report",
            "twistcore refine walk.bvh -o walk.clean.bvh --session walk.twist.json",
            "twistcore refine - -o - --min-confidence 0.9 < walk.bvh > walk.clean.bvh",
        ),
    ),
    "apply": CommandHelp(
        "write the corrections accepted in sessions",
        "A session is a review that the window or `twistcore refine --session` wrote. The result "
        "is the same, byte for byte, as the window's export. With two folders, each session is "
        "applied to its clip, and OUT is a folder.",
        (
            "twistcore apply walk.twist.json walk.bvh -o walk.clean.bvh",
            "twistcore apply reviewed captures -o corrected --workers 4",
        ),
    ),
    "report": CommandHelp(
        "write web pages for a session or a batch folder",
        "",
        (
            "twistcore report walk.twist.json -o pages --clip walk.bvh",
            "twistcore report out -o pages --pages 50 --no-pictures",
        ),
    ),
    "inject": CommandHelp(
        "inject known errors into a clip",
        "The errors are drawn at random according to a protocol. The truth file lists them for "
        "`evaluate`.",
        ("twistcore inject walk.bvh -o bad.bvh --truth bad.truth.json --seed 1",),
    ),
    "evaluate": CommandHelp(
        "measure a refinement against the injected errors",
        "Give the same number of files to all three options to measure several clips together.",
        ("twistcore evaluate --truth bad.truth.json --clean walk.bvh --refined refined.bvh",),
    ),
    "tune": CommandHelp(
        "find τ for each joint and write a profile",
        "τ is learned from injected errors or, with --verdicts, from the intervals that reviewers "
        "accepted or rejected. Other commands read the profile with --profile.",
        (
            "twistcore tune captures -o rig.toml --workers 4",
            "twistcore tune captures -o rig.toml --verdicts --performer Kim",
        ),
    ),
    "benchmark": CommandHelp(
        "compare methods on injected errors",
        "Prints the tables. An interrupted run continues with --resume.",
        ("twistcore benchmark captures --protocol P0 H1 --methods detectors --json bench.json",),
    ),
    "batch": CommandHelp(
        "process many clips and write the results into a folder",
        "Each clip is processed separately: if one crashes, hangs or takes too much memory, it is "
        "listed and the others continue. OUTDIR keeps the results in manifest.sqlite. Run the "
        "command again to continue an interrupted run, and to process clips that are new or whose "
        "bytes, options or program version have changed.",
        (
            "twistcore batch captures -o out --refine --report",
            "twistcore batch 'takes/**/*_raw.bvh' @more.txt -o out --fail-if 'severity>5' "
            "--csv o.csv",
            "twistcore batch captures -o out-3 --shard 3/20",
        ),
        "Exit code: 0 done; 1 finished, but a clip could not be processed, a PATH matched no clip, "
        "with --refine an interval could not be corrected, or a rule of --fail-if is broken (all "
        "listed); 2 wrong usage, or no clip could be read; 130 stopped with Ctrl+C.",
    ),
    "watch": CommandHelp(
        "process the clips of a folder as they arrive, until the command is stopped",
        "Each new or changed clip is processed as with `twistcore batch` once it is "
        "completely written, and all results are updated. Stop the command with Ctrl+C; "
        "run the same command again to continue.",
        (
            "twistcore watch deliveries -o out --report",
            "twistcore watch deliveries -o out --fail-if 'severity>5' --csv out.csv --idle 3600",
            "twistcore watch deliveries -o out --once",
        ),
        "Exit code: 0 or 1 as for `twistcore batch`, based on the latest results, also after "
        "Ctrl+C; 1 if a clip was still being written; 2 wrong usage; 130 stopped while clips "
        "were being processed.",
    ),
    "merge": CommandHelp(
        "merge the folders of several batches, such as shards, into one",
        "Copies the clips, results, decisions and corrected files into OUTDIR. If several folders "
        "have the same clip, the latest result is used. `twistcore batch` with the same OUTDIR and "
        "all PATHs then processes the remaining clips.",
        (
            "twistcore merge out-1 out-2 out-3 -o out",
            "twistcore merge out/shard-* -o out/all",
        ),
        "Exit code: 0 done; 1 merged, but a clip has failed or was not processed, or a corrected "
        "file could not be copied (all listed); 2 wrong usage, or a damaged folder.",
    ),
    "quamo": CommandHelp(
        "track or smooth jittery motion after the review",
        "Correct twist errors first: tracking would smear their edges.",
        ("twistcore quamo refine walk.bvh -o smooth.bvh",),
    ),
    "export": CommandHelp(
        "write accepted corrections as keys for the scene of a clip",
        "Writes a Python script. Run it in Blender, Maya or MotionBuilder with the original scene "
        "open (docs/pipelines.md). The session comes from the window or from "
        "`twistcore refine --session`.",
        (
            "twistcore export walk.twist.json walk.bvh --script maya -o keys.py",
            "twistcore export walk.twist.json walk.bvh --script blender -o keys.py --dry-run",
        ),
    ),
    "convert": CommandHelp(
        "write the skeleton of an FBX, glTF or .blend file as BVH, or a clip as glTF",
        "Blender reads the file in a separate process, so Blender must be installed "
        "(docs/pipelines.md). A .glb is written without Blender and contains the joints and their "
        "animation, but no End Sites.",
        (
            "twistcore convert take.fbx -o take.bvh",
            "twistcore convert walk.bvh -o walk.glb --unit 0.056444",
            "twistcore convert scene.glb -o dance.bvh --take Dance --blender /opt/blender/blender",
        ),
    ),
    "clean": CommandHelp(
        "rewrite a clip with other angles, axes, units, channels, names or rates",
        "Each option changes only what it names; all other bytes stay the same. The "
        "changed joints and frames are listed. The written file is read again and "
        "compared with the source. Clips in other formats are written as BVH.",
        (
            "twistcore clean walk.bvh -o walk.clean.bvh --unroll",
            "twistcore clean walk.bvh -o out.bvh --order ZXY --channels 3 --scale 0.01",
            "twistcore clean walk.bvh -o out.bvh --fps 60 --rename smpl --json",
        ),
        "A review belongs to the original clip, because its session stores the hash of "
        "the clip and the joint names of its chains. Export the corrections first, and "
        "clean the corrected clip. Exit code: 1 if the written poses differ from the "
        "source by more than 1e-4° or 1e-4 of the figure's height.",
    ),
    "completion": CommandHelp(
        "print a script that lets a shell complete commands, options and files",
        "",
        (
            "twistcore completion bash > ~/.local/share/bash-completion/completions/twistcore",
            "twistcore completion zsh > ~/.zfunc/_twistcore",
            "twistcore completion fish > ~/.config/fish/completions/twistcore.fish",
        ),
    ),
    "help": CommandHelp(
        "show this help, or the help of a command",
        "",
        ("twistcore help", "twistcore help detect", "twistcore help quamo refine"),
    ),
    "quamo refine": CommandHelp(
        "smooth or track a clip and write the result",
        "CLIP is a BVH or a pose file (.npz, .pkl). The spline is best for a file, and the "
        "tracker for a stream. Reports jitter, foot slide and deviation before and after.",
        (
            "twistcore quamo refine walk.bvh -o smooth.bvh",
            "twistcore quamo refine walk.bvh -o smooth.bvh --cutoff 5",
            "twistcore quamo refine walk.bvh -o smooth.bvh --where noisy",
            "twistcore quamo refine walk.bvh -o smooth.bvh --causal",
            "twistcore quamo refine poses.npz -o smooth.bvh --up z --fps 30",
        ),
    ),
    "quamo noise": CommandHelp(
        "add synthetic noise to a clip",
        "",
        ("twistcore quamo noise walk.bvh -o noisy.bvh --level B --seed 1",),
    ),
    "quamo evaluate": CommandHelp(
        "compare learned gains and gains set by hand with baselines on held-out subjects",
        "",
        ("twistcore quamo evaluate cmu --weights assets/quamo --seeds 1",),
    ),
    "quamo ablation": CommandHelp(
        "compare steps of the method, representations and integrators",
        "",
        ("twistcore quamo ablation cmu --weights assets/quamo --json",),
    ),
    "quamo train": CommandHelp(
        "train the networks (needs PyTorch)",
        "Writes one file of weights for each held-out subject and continues an interrupted run.",
        ("twistcore quamo train cmu -o weights --hold-out 05 --epochs 10",),
    ),
}
