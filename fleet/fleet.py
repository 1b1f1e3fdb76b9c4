#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Maps a site from many recordings: fleet/README.md.

  fleet.py add SITE RECORDING… [-- OPTIONS OF covis run]   adds recordings to SITE/manifest.json, as one batch
  fleet.py retry SITE                                      forgets failed jobs, so that they are tried again
  fleet.py job SITE COVIS KEY ATTEMPT                      does one job of the plan (the Snakefile calls it)
  fleet.py report SITE COVIS                               writes SITE/report
"""
from __future__ import annotations

import pathlib
import shutil
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import jobs  # noqa: E402
import plan  # noqa: E402
import report  # noqa: E402

ATTEMPTS = 3  # what fails so often is recorded as failed; the profiles' `retries` and one more


def run_job(site: pathlib.Path, covis: pathlib.Path, key: str, last_attempt: bool) -> None:
    manifest = plan.Manifest.load(site)
    root, _, errors = key.partition('-')
    job = jobs.Job(site, covis, key)
    if errors:
        job.make(lambda made: jobs.evaluate(made, site, root, manifest.recordings()), last_attempt)
    else:
        node = plan.plan_of(manifest, plan.identity_of(covis)).nodes[key]

        def work(made: jobs.Job) -> jobs.Json:
            if node.recording:
                return jobs.map_recording(made, node.recording, manifest.run_options)
            try:
                return jobs.merge_nodes(made, site, node, manifest.merge_options)
            except jobs.JobError as error:
                if not last_attempt:
                    raise
                return jobs.keep_apart(made, site, node, str(error))

        job.make(work, last_attempt)


def retry(site: pathlib.Path) -> list[str]:
    """Forgets what failed, and the merges that had to do without it."""
    results = {folder.name: jobs.load_result(site, folder.name) for folder in (site / 'jobs').iterdir()
               if (folder / 'result.json').exists()}
    forgotten = {key for key, result in results.items() if 'failed' in result}
    while more := {key for key, result in results.items() if forgotten & set(result.get('inputs', []))} - forgotten:
        forgotten |= more
    for key in sorted(forgotten):
        for done in (site / 'done').glob(f'*/{key}'):
            done.unlink()
        shutil.rmtree(site / 'jobs' / key)
    return sorted(forgotten)


def main(words: list[str]) -> int:
    options: list[str] = []
    if '--' in words:
        words, options = words[:words.index('--')], words[words.index('--') + 1:]
    try:
        match words:
            case ['add', site, *recordings] if recordings:
                print('\n'.join(plan.add(pathlib.Path(site), recordings, options)))
            case ['retry', site]:
                print(f'{len(retry(pathlib.Path(site)))} jobs will be done again')
            case ['job', site, covis, key, attempt]:
                run_job(pathlib.Path(site), pathlib.Path(covis), key, int(attempt) >= ATTEMPTS)
            case ['report', site, covis]:
                folder = pathlib.Path(site)
                manifest = plan.Manifest.load(folder)
                data = report.publish(folder, manifest, plan.plan_of(manifest, plan.identity_of(pathlib.Path(covis))))
                for i, place in enumerate(data['places']):
                    print(f'place {i}: {place["key_frames"]} key frames of {", ".join(place["recordings"])}')
                for r in data['recordings']:
                    if r['failed']:
                        print(f'not mapped: {r["name"]}: {r["failed"]}')
                print(f'see {folder / "report/report.html"}')
            case _:
                print(__doc__, file=sys.stderr)
                return 2
    except (plan.SiteError, jobs.JobError, OSError) as error:
        print(f'error: {error}', file=sys.stderr)
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
