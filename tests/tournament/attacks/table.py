"""All attacks, and what each level of isolation makes of them; docs/attacks.md shows the same."""

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Final

from tournament.attacks import channels, files, processes, resources, seeds
from tournament.attacks.harness import LONG_SEED, Attack
from tournament.attacks.world import Outcome

STOPPED: Final = "stopped"
NOT_STOPPED: Final = "not stopped"
BY_LUCK: Final = "not stopped, where it has luck"
BY_SOME_KERNELS: Final = "not stopped by all kernels"
AS_ROOT: Final = "stopped, but not where the tournament runs as root"
ROOT_STOPS: Final = "not stopped, but where the tournament runs as root or has control groups"
GROUPS_STOP: Final = "not stopped, but where the tournament has control groups"
NEITHER_ROOT_NOR_GROUPS: Final = "stopped, but not where the tournament runs as root or has control groups"
IMPATIENT: Final = {"step_ms": 1500, "bank_s": 0.5}
"""For agents that somebody stops, and that are late then."""


def leaked(outcome: Outcome) -> bool:
    """The attacker knows a secret."""
    return any(secret in outcome.said for secret in outcome.secrets)


def done(outcome: Outcome) -> bool:
    """The attacker did what it tried, and says so."""
    return "found " in outcome.said


def beaten(outcome: Outcome) -> bool:
    """The rival forfeited, or the tournament did not end as it should."""
    return outcome.broken


def changed(name: str) -> Callable[[Outcome], bool]:
    """A file of that name, or ending, is not what it was."""

    def succeeded(outcome: Outcome) -> bool:
        return any(path.name.endswith(name) for path in outcome.changes)

    return succeeded


def remembered(outcome: Outcome) -> bool:
    """A match knew what the one before had kept."""
    return "found carried" in outcome.said


def framed(outcome: Outcome) -> bool:
    """The rival's log has what it did not print."""
    return "I am a cheat" in outcome.rival_said


def spoiled(outcome: Outcome) -> bool:
    """The store has a table of the attacker's, or the tournament failed for it."""
    return outcome.broken or b"CREATE TABLE mine" in (outcome.world.out / "tournament.sqlite").read_bytes()


def reached_the_world(outcome: Outcome) -> bool:
    """A message came through."""
    return outcome.received == b"hello, world"


def outlived(outcome: Outcome) -> bool:
    """A process of the first match lived while the second was played."""
    return outcome.most > 1


def obeyed(outcome: Outcome) -> bool:
    """What is shown in a terminal holds what it obeys."""
    return "\x1b" in outcome.printed or "\x1b" in outcome.said


def read_as_markup(outcome: Outcome) -> bool:
    """The attacker's name is not shown as it stands."""
    return "[red]attacker" not in outcome.printed


def heard_by_locks(outcome: Outcome) -> bool:
    """The first 32 bits of the secret came through."""
    return f"found bits {outcome.world.secret[7:15]}" in outcome.said


def saw_all_of_the_home(outcome: Outcome) -> bool:
    """Not only what leads to Python, which may be installed there."""
    return f"found {len(os.listdir(Path.home()))} entries" in outcome.said


def attack(run, succeeded, by_processes, by_namespaces, **options) -> Attack:
    """A row of the table."""
    return Attack(run=run, succeeded=succeeded, processes=by_processes, namespaces=by_namespaces, **options)


def quiet(run, succeeded, by_processes, by_namespaces) -> Attack:
    """One that leaves the match as it is: one agent tries them all."""
    return attack(run, succeeded, by_processes, by_namespaces, together="looks", rounds=2)


def hidden_memory(run, by_processes, by_namespaces) -> Attack:
    """One that takes more than an agent may have, where no process of its own holds it; one agent tries them all."""
    return attack(run, done, by_processes, by_namespaces, together="memory", limits={"memory_mib": 64})


ATTACKS: Final = (
    # the match's seed, and what follows from it
    quiet(seeds.works_out_the_matchs_seed_from_its_own, leaked, STOPPED, STOPPED),
    attack(seeds.works_out_a_seed_that_was_short, leaked, NOT_STOPPED, NOT_STOPPED, words=("--seed", "7")),
    quiet(seeds.reads_the_seeds_in_the_store, leaked, NOT_STOPPED, STOPPED),
    attack(
        seeds.reads_the_seed_in_the_tournaments_command_line,
        leaked,
        NOT_STOPPED,
        STOPPED,
        words=("--seed", LONG_SEED),
        alone=True,
    ),
    attack(files.reads_the_replay_of_a_match_with_the_same_targets, done, STOPPED, STOPPED),
    # the rival's process
    attack(processes.writes_into_the_rivals_answers_through_proc, beaten, STOPPED, STOPPED, limits=IMPATIENT),
    attack(processes.takes_the_rivals_descriptors_by_pidfd, beaten, AS_ROOT, STOPPED, limits=IMPATIENT),
    quiet(processes.writes_into_the_rivals_log_through_proc, framed, STOPPED, STOPPED),
    quiet(processes.reads_the_rivals_memory_through_proc, leaked, AS_ROOT, STOPPED),
    quiet(processes.reads_the_rivals_memory_by_process_vm_readv, leaked, AS_ROOT, STOPPED),
    quiet(processes.takes_hold_of_the_rival_by_ptrace, done, AS_ROOT, STOPPED),
    attack(processes.kills_the_rival, beaten, STOPPED, STOPPED),
    attack(processes.stops_the_rival, beaten, STOPPED, STOPPED, limits=IMPATIENT),
    attack(processes.takes_all_cpu_time_from_the_rival_by_prlimit, beaten, STOPPED, STOPPED),
    quiet(processes.changes_the_rivals_limits, done, STOPPED, STOPPED),
    quiet(processes.makes_the_rival_slow_by_its_priority, done, NOT_STOPPED, STOPPED),
    quiet(processes.takes_a_priority_above_all_others, done, AS_ROOT, STOPPED),
    # the tournament's processes
    quiet(processes.reads_the_tournaments_memory, leaked, AS_ROOT, STOPPED),
    quiet(processes.reads_the_tournaments_environment, leaked, AS_ROOT, STOPPED),
    attack(processes.kills_its_fork_server, beaten, STOPPED, STOPPED, limits=IMPATIENT),
    attack(processes.stops_its_fork_server, beaten, STOPPED, STOPPED, limits=IMPATIENT),
    attack(
        processes.lies_about_how_it_ended,
        beaten,
        STOPPED,
        STOPPED,
        at_import=processes.changes_what_its_fork_server_says,
    ),
    attack(processes.kills_the_supervisor, beaten, STOPPED, STOPPED),
    attack(processes.stops_the_supervisor, beaten, STOPPED, STOPPED),
    attack(processes.kills_the_tournament, beaten, NOT_STOPPED, STOPPED),
    attack(processes.stops_itself, beaten, STOPPED, STOPPED, limits=IMPATIENT),
    attack(
        processes.leaves_a_grandchild_that_lives_on_into_the_next_match,
        outlived,
        STOPPED,
        STOPPED,
        counted=b"98765.4321",
    ),
    attack(processes.passes_descriptors_to_the_tournament, beaten, STOPPED, STOPPED),
    quiet(channels.finds_descriptors_that_are_not_its_own, done, STOPPED, STOPPED),
    # privileges
    quiet(processes.gains_privileges_by_a_program_that_is_setuid, done, STOPPED, STOPPED),
    quiet(processes.has_capabilities, done, AS_ROOT, STOPPED),
    quiet(processes.makes_a_user_namespace_of_its_own, done, BY_SOME_KERNELS, STOPPED),
    quiet(resources.raises_its_own_limits, done, AS_ROOT, STOPPED),
    quiet(files.makes_a_device, done, AS_ROOT, STOPPED),
    quiet(files.opens_a_disk_of_this_machine, done, AS_ROOT, STOPPED),
    quiet(files.finds_a_control_group_that_it_may_change, done, NEITHER_ROOT_NOR_GROUPS, STOPPED),
    # files of others
    quiet(files.reads_the_rivals_files, leaked, NOT_STOPPED, STOPPED),
    attack(
        files.reads_the_files_of_a_rival_that_lies_in_the_same_folder,
        leaked,
        NOT_STOPPED,
        STOPPED,
        file="rival/attacker.py",
    ),
    attack(
        files.reads_a_file_in_the_same_folder_whose_name_is_nobodys,
        leaked,
        NOT_STOPPED,
        NOT_STOPPED,
        file="rival/attacker.py",
    ),
    attack(
        files.follows_links_that_were_handed_in,
        leaked,
        NOT_STOPPED,
        STOPPED,
        links={"data": "home/key", "home": "home"},
    ),
    attack(
        files.names_a_file_that_is_not_its_own_as_its_source,
        beaten,
        STOPPED,
        STOPPED,
        at_import=files.says_that_its_source_is_its_memory,
        file="../packages/attacker.py",
        spec="attacker:Agent",
    ),
    attack(
        files.names_a_source_that_no_file_can_have,
        beaten,
        STOPPED,
        STOPPED,
        at_import=files.says_that_its_source_is_very_long,
    ),
    attack(files.reads_the_spec_that_it_is_graded_by, leaked, NOT_STOPPED, STOPPED, graded=True, file="attacker.py"),
    quiet(files.changes_the_rivals_source, changed("rival.py"), NOT_STOPPED, STOPPED),
    quiet(files.reads_the_rivals_working_folder, leaked, NOT_STOPPED, STOPPED),
    attack(files.changes_what_the_rival_has_written, beaten, NOT_STOPPED, STOPPED),
    quiet(files.finds_the_rivals_working_folder_through_proc, leaked, AS_ROOT, STOPPED),
    quiet(files.reads_a_file_in_the_users_home, leaked, NOT_STOPPED, STOPPED),
    quiet(files.lists_the_users_home, saw_all_of_the_home, NOT_STOPPED, STOPPED),
    quiet(files.finds_a_way_out_through_proc, leaked, NOT_STOPPED, STOPPED),
    quiet(files.finds_the_tournaments_folders_through_its_descriptors, done, AS_ROOT, STOPPED),
    attack(files.writes_into_the_store, spoiled, NOT_STOPPED, STOPPED),
    quiet(files.changes_a_replay, changed(".replay"), NOT_STOPPED, STOPPED),
    quiet(files.reads_the_rivals_log, leaked, NOT_STOPPED, STOPPED),
    quiet(files.writes_a_module_that_python_imports_at_every_start, changed("sitecustomize.py"), NOT_STOPPED, STOPPED),
    quiet(files.opens_a_module_of_the_package_for_writing, done, NOT_STOPPED, STOPPED),
    quiet(files.changes_its_own_source_between_matches, changed("attacker.py"), NOT_STOPPED, STOPPED),
    attack(files.removes_its_own_source_while_it_plays, beaten, STOPPED, STOPPED),
    # its own folder, which the tournament clears up
    quiet(files.links_from_its_folder_to_somebody_elses, changed("key"), STOPPED, STOPPED),
    attack(
        files.swaps_a_folder_and_a_link_while_they_are_cleared_up,
        changed("key"),
        BY_LUCK,
        STOPPED,
        at_import=files.swaps_for_ever,
    ),
    attack(files.puts_a_link_in_the_place_of_its_folder, beaten, STOPPED, STOPPED),
    attack(files.takes_the_folder_of_the_next_seat, beaten, STOPPED, STOPPED, at_import=files.takes_all_seats),
    attack(files.removes_the_folder_that_all_work_in, beaten, STOPPED, STOPPED),
    attack(files.digs_folders_too_deep_to_be_removed, beaten, STOPPED, STOPPED),
    attack(files.forbids_its_own_folder, beaten, STOPPED, STOPPED),
    attack(files.makes_its_folder_immutable, beaten, AS_ROOT, STOPPED),
    attack(files.leaves_a_pipe_and_a_socket_in_its_folder, beaten, STOPPED, STOPPED),
    # the machine's resources
    quiet(files.writes_a_file_of_100_gb_with_holes, done, STOPPED, STOPPED),
    quiet(files.writes_many_files, done, NOT_STOPPED, STOPPED),
    attack(resources.forks_300_processes, done, BY_LUCK, AS_ROOT),
    attack(resources.starts_10_000_threads, done, STOPPED, STOPPED),
    attack(resources.takes_memory_in_many_processes, done, STOPPED, STOPPED, limits={"memory_mib": 64}),
    attack(resources.takes_memory_by_forgetting_what_it_shares, done, ROOT_STOPS, STOPPED, limits={"memory_mib": 128}),
    attack(resources.takes_memory_by_pipes_that_nobody_reads, done, AS_ROOT, STOPPED, limits={"memory_mib": 256}),
    hidden_memory(resources.takes_memory_by_files_in_memory, STOPPED, STOPPED),
    hidden_memory(resources.takes_memory_by_system_v_segments, STOPPED, STOPPED),
    hidden_memory(resources.takes_memory_by_system_v_segments_and_calls_of_32_bits, STOPPED, STOPPED),
    hidden_memory(resources.takes_memory_by_system_v_messages, STOPPED, STOPPED),
    hidden_memory(resources.takes_memory_by_pages_that_lie_in_pipes, STOPPED, STOPPED),
    hidden_memory(resources.takes_memory_by_rings_of_the_kernel, STOPPED, STOPPED),
    hidden_memory(resources.takes_memory_by_connections_that_nobody_reads, GROUPS_STOP, GROUPS_STOP),
    attack(resources.runs_away_by_forking_for_ever, beaten, STOPPED, STOPPED),
    # what it says
    attack(resources.prints_for_ever_while_it_plays, beaten, STOPPED, STOPPED),
    attack(resources.answers_without_a_newline_for_ever, beaten, STOPPED, STOPPED),
    attack(resources.answers_10_mb, beaten, STOPPED, STOPPED),
    attack(resources.answers_with_brackets_in_brackets, beaten, STOPPED, STOPPED),
    attack(resources.raises_an_exception_that_is_no_text, beaten, STOPPED, STOPPED),
    attack(resources.prints_what_a_terminal_obeys, obeyed, STOPPED, STOPPED),
    attack(
        resources.has_a_name_that_a_table_could_take_for_markup,
        read_as_markup,
        STOPPED,
        STOPPED,
        file="attacker/[red]attacker.py",
    ),
    # the network, and agents in league
    quiet(channels.sends_something_out_by_network, reached_the_world, NOT_STOPPED, STOPPED),
    quiet(channels.finds_an_interface_of_the_network, done, NOT_STOPPED, STOPPED),
    *(
        attack(hears, leaked, NOT_STOPPED, STOPPED, accomplice=sends, together="talks")
        for hears, sends in (
            (channels.hears_an_accomplice_by_tcp, channels.sends_the_secret_by_tcp),
            (channels.hears_an_accomplice_by_an_abstract_socket, channels.sends_the_secret_by_an_abstract_socket),
            (
                channels.hears_an_accomplice_by_a_socket_among_the_temporary_files,
                channels.sends_the_secret_by_a_socket_among_the_temporary_files,
            ),
            (channels.hears_an_accomplice_by_shared_memory, channels.sends_the_secret_by_shared_memory),
            (channels.hears_an_accomplice_by_a_temporary_file, channels.sends_the_secret_by_a_temporary_file),
        )
    ),
    attack(
        channels.hears_an_accomplice_by_system_v_shared_memory,
        leaked,
        STOPPED,
        STOPPED,
        accomplice=channels.sends_the_secret_by_system_v_shared_memory,
        together="talks",
    ),
    attack(
        channels.hears_an_accomplice_by_locks_on_files_that_all_may_read,
        heard_by_locks,
        NOT_STOPPED,
        NOT_STOPPED,
        accomplice=channels.sends_the_secret_by_locks_on_files_that_all_may_read,
        together="talks",
    ),
    # from one match to the next
    attack(
        channels.works_on_between_its_matches,
        done,
        NOT_STOPPED,
        NOT_STOPPED,
        at_import=channels.counts_for_ever,
        together="server",
    ),
    quiet(channels.remembers_a_match_by_a_temporary_file, remembered, NOT_STOPPED, STOPPED),
    quiet(channels.remembers_a_match_by_a_file_in_its_home, remembered, STOPPED, STOPPED),
    quiet(channels.remembers_a_match_by_a_file_beside_its_source, remembered, NOT_STOPPED, STOPPED),
    quiet(channels.remembers_a_match_by_shared_memory, remembered, NOT_STOPPED, STOPPED),
    quiet(channels.remembers_a_match_by_system_v_shared_memory, remembered, STOPPED, STOPPED),
    attack(
        channels.remembers_a_match_by_memory_that_its_fork_server_shares,
        remembered,
        NOT_STOPPED,
        NOT_STOPPED,
        at_import=channels.maps_memory_to_share,
        together="server",
    ),
    attack(
        channels.remembers_a_match_by_a_thread_of_its_fork_server,
        remembered,
        NOT_STOPPED,
        NOT_STOPPED,
        at_import=channels.starts_a_thread_that_listens,
        together="server",
    ),
    quiet(channels.remembers_a_match_by_a_key_that_the_kernel_keeps, remembered, STOPPED, STOPPED),
    quiet(channels.remembers_a_match_by_a_posix_message_queue, remembered, STOPPED, STOPPED),
)

_SPELLED: Final = {
    "rivals": "rival's",
    "matchs": "match's",
    "tournaments": "tournament's",
    "users": "user's",
    "nobodys": "nobody's",
    "elses": "else's",
    "system v": "System V",
    "tcp": "TCP",
    "posix": "POSIX",
    "python": "Python",
    "proc": "/proc",
    "pidfd": "pidfd_getfd",
    "100 gb": "100 GB",
    "10 mb": "10 MB",
    "10 000": "10,000",
}
"""How words are spelled that a function's name cannot hold."""


def rows() -> list[str]:
    """As docs/attacks.md has them."""
    lines = []
    for one in ATTACKS:
        name = one.name
        for word, spelled in _SPELLED.items():
            name = re.sub(rf"\b{word}\b", spelled, name)
        lines.append(f"| {name} | {one.processes} | {one.namespaces} |")
    return lines
