"""The command `review`: a page, served on this machine alone, in which a person sets the last labels."""

import argparse
import webbrowser
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from dshpm_jax import io
from dshpm_jax._archive.jobs import find_jobs
from dshpm_jax._archive.manifest import MANIFEST_NAME
from dshpm_jax._commands.statuses import OK
from dshpm_jax._compile_cache import cache_programs
from dshpm_jax._console import complain, say
from dshpm_jax._corrections import CorrectionsError
from dshpm_jax._messages import UsageError
from dshpm_jax._review.places import Place, place_of, places_in

ABOUT = "a page in which a person sets the last labels"


def add_options(parser: argparse.ArgumentParser) -> None:
    """The options of `review`."""
    about = (
        "folder of results, as 'label' wrote it; with -o, a recording or a folder of recordings to name from nothing"
    )
    parser.add_argument("folder", type=Path, metavar="FOLDER", help=about)
    about = "folder for the results of recordings that nobody labelled"
    parser.add_argument("-o", "--output", dest="out", type=Path, metavar="OUT", help=about)
    about = "take over labels that another program changed in results, as corrections"
    parser.add_argument("--adopt", action="store_true", help=about)
    parser.add_argument("--port", type=_port, default=0, metavar="N", help="serve the page at this port (default: any)")
    parser.add_argument("--no-open", action="store_true", help="do not open the page in the browser")


def run(arguments: argparse.Namespace) -> int:
    """Serves the page until Ctrl-C, and gives the exit status."""
    places = _places(arguments.folder, arguments.out)
    if arguments.adopt:
        _adopt(places.values())
    cache_programs()
    from dshpm_jax._review.desk import Desk
    from dshpm_jax._review.serving import Server

    desk = Desk(places, (arguments.out or arguments.folder).resolve().name)
    try:
        server = Server(desk, arguments.port)
    except ImportError as error:
        raise UsageError(str(error)) from None
    except OSError as error:
        raise UsageError(f"--port {arguments.port}: cannot be used ({error.strerror}); give another") from None
    say(server.address)
    say("served on this machine alone until Ctrl-C; what you correct is kept at once")
    if not arguments.no_open and not webbrowser.open(server.address):
        complain("found no browser; open the address yourself")
    server.run()
    return OK


def _places(given: Path, out: Path | None) -> dict[str, Place]:
    """The trials of a folder of results, and those of recordings whose results go there."""
    if out is None:
        if not (given / MANIFEST_NAME).is_file():
            remedy = "give a folder that 'label' wrote, or -o with a folder for the results"
            raise UsageError(f"{given}: holds no {MANIFEST_NAME}; {remedy}")
        return places_in(given)
    if not given.exists():
        raise UsageError(f"{given}: there is no such file or folder; check the path")
    jobs = [job for job in find_jobs([given], [], out) if job.source.is_file() and not job.clashes]
    found = places_in(out) if out.exists() else {}
    own = {place.id: place for place in (place_of(out, replace(job, models=(), page=True)) for job in jobs)}
    return own | found


def _adopt(places: Iterable[Place]) -> None:
    """Takes over what other programs changed in results, and says so."""
    from dshpm_jax._archive.adopting import take_over

    for place in places:
        if not place.result.is_file():
            continue
        try:
            for correction in take_over(place.result, place.job.source):
                say(f"{place.result}: {len(correction.changes)} changed labels taken over")
        except (io.ReadError, CorrectionsError, OSError) as error:
            complain(error)


def _port(text: str) -> int:
    if not text.isdecimal() or not int(text) < 1 << 16:
        raise argparse.ArgumentTypeError(f"'{text}' is no port such as 8008")
    return int(text)
