"""Examples of every command, which its `--help` ends with."""

EXAMPLES = {
    "demo": """\
dshpm-jax demo -o demo                 a capture, its labels and their scores, a picture and a page
dshpm-jax demo --archive -o captures   a small archive to try the other commands on""",
    "model": """\
dshpm-jax model anna/rom.c3d -o anna/model.json               best: a recording in which every joint moves
dshpm-jax model anna/rom.c3d anna/walk.c3d -o anna/model.json
dshpm-jax model anna -o anna/model.json                       what is labelled in that folder
dshpm-jax model --from labelled -o anna/model.json            again, from results that are confirmed or sure
dshpm-jax model static.c3d --template plug-in-gait -o model.json
dshpm-jax model nick.vsk -o model.json                        the subject file of a capture system
dshpm-jax model --subjects anna ben carl dora -o set.json     a marker set, for subjects of whom nothing is labelled""",
    "models": """\
dshpm-jax models captures --dry-run    say what would be used, and what not, and why
dshpm-jax models captures              a model.json in every folder that holds labelled recordings
dshpm-jax models captures --force      make those again that are there""",
    "label": """\
dshpm-jax label walk.c3d --model model.json -o labelled
dshpm-jax label captures -o labelled --dry-run                each trial with the nearest model.json
dshpm-jax label captures -o labelled --workers 4 --open
dshpm-jax label half.c3d -o labelled --keep-labels            what has a name keeps it, the rest is labelled around it
dshpm-jax label duet.c3d --model anna.json --model ben.json -o labelled
dshpm-jax label captures/eve --model set.json -o labelled     by a marker set; eve's own model is kept in labelled
dshpm-jax label captures -o for-opensim --format trc --up y --unit m""",
    "check": """\
dshpm-jax check walk.c3d --model model.json
dshpm-jax check anna/walk.c3d anna/run.c3d --model anna/model.json --json findings.json""",
    "view": """\
dshpm-jax view labelled/walk.c3d --open
dshpm-jax view labelled                       all pages of a run, and its report
dshpm-jax view walk.c3d --model model.json -o walk.html""",
    "review": """\
dshpm-jax review labelled              the trials of a run, those with the most points at stake first
dshpm-jax review labelled --adopt      labels that another program changed become corrections
dshpm-jax review static.c3d -o named   a recording without labels, named by clicking""",
    "experiment": """\
dshpm-jax experiment table1 --trials 5
dshpm-jax experiment corruption -o corruption --workers 4""",
    "reconstruct": """\
dshpm-jax reconstruct labelled/walk.c3d --model model.json -o motion
dshpm-jax reconstruct labelled/walk.c3d --model model.json -o motion --fill --max-gap 0.5""",
}
"""By command: lines of a command and, three blanks or more behind it, what it is for."""
