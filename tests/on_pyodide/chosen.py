"""The tests of the dashboard that run on Pyodide, and why the others do not."""

from __future__ import annotations

# Each part is a process of Node.
PARTS = {
    "the API": (
        "test_access.py", "test_api_actions.py", "test_api_cars.py", "test_api_causes.py",
        "test_api_channels.py", "test_api_co.py", "test_api_connection.py",
        "test_api_errors.py", "test_api_exports.py", "test_api_foreign.py",
        "test_api_foreign_logs.py", "test_api_guided_tests.py", "test_api_instrument_formulas.py",
        "test_api_instruments.py",
        "test_api_live.py", "test_api_marks.py", "test_api_messages.py",
        "test_api_recorded_faults.py", "test_api_recorded_instruments.py",
        "test_api_recordings.py", "test_api_references.py", "test_api_report.py",
        "test_api_search.py", "test_api_survey.py", "test_api_trips.py", "test_api_unit.py",
        "test_api_virtual_cars.py",
        "test_api_writing.py",
        "test_unkept_things.py",
    ),
    "what is behind the API": (
        "test_confirmations.py", "test_control.py", "test_dump_jobs.py", "test_dump_jobs_kept.py",
        "test_hostile_text.py", "test_ignition_only_units.py", "test_kept_files.py",
        "test_lanes.py", "test_long_work.py",
        "test_monitor_alarms.py", "test_monitor_dropped.py", "test_monitor_errors.py",
        "test_monitor_gaps.py", "test_port_threads.py", "test_session_connection.py",
        "test_session_fault_history.py", "test_session_freeze_frames.py",
        "test_session_recorder.py", "test_true_dates.py",
        "test_dates_of_the_page.py",
    ),
}  # fmt: skip

_SOCKET = "is about a socket of the desktop's server"
_HEADERS = "sends headers that a page can't send, or reads the status of a refused WebSocket"
_PORTS = "is about ports that a page does not have"
_TABLES = "compares with numpy and pandas, or reads MDF4 and Parquet"
_NO_PAUSE = "its thread computes without a wait, and on Pyodide nothing else runs meanwhile"
_PROGRAMS = "is about two programs on one disk"
_HYPOTHESIS = "needs Hypothesis, which has no wheel for Pyodide"

LEFT_OUT = {
    "test_another_program.py": _PROGRAMS,
    "test_certificate.py": _SOCKET,
    "test_client_manners.py": _SOCKET,
    "test_connections.py": _SOCKET,
    "test_connections_served.py": _SOCKET,
    "test_ending.py": "ends a program of the desktop",
    "test_entrance.py": _SOCKET,
    "test_memory_given_back.py": "counts what the desktop's process holds",
    "test_running.py": _SOCKET,
    "test_secrets_of_ports.py": _SOCKET,
    "test_addresses.py": _SOCKET,
    "test_server.py": _SOCKET,
    "test_server_loops.py": _SOCKET,
    "test_history.py": _TABLES,
    "test_hostile_folders.py": "is about the files of a real disk",
    "test_names.py": _HYPOTHESIS,
    "test_openapi.py": _HYPOTHESIS,
    "test_sharing.py": _SOCKET,
    "test_settings.py": "is about the command line",
    "test_work_of_routes.py": _NO_PAUSE,
    "test_access.py::test_a_foreign_socket_gets_403": _HEADERS,
    "test_access.py::test_a_socket_without_a_name_is_refused": _HEADERS,
    "test_access.py::test_from_the_network_no_instrument_elsewhere_can_be_named": _PORTS,
    "test_access.py::test_a_viewer_from_the_network_sees_everything_and_touches_nothing": _HEADERS,
    "test_access.py::test_from_the_network_an_adapter_or_a_virtual_car_may_be_chosen": _HEADERS,
    "test_access.py::test_from_the_network_no_file_and_no_address_can_be_named": _HEADERS,
    "test_access.py::test_from_the_network_no_webhook_and_no_broker_can_be_named": _HEADERS,
    "test_access.py::test_from_the_network_what_is_in_use_may_be_examined": _HEADERS,
    "test_access.py::test_no_header_names_the_sender_whatever_the_environment_says": _HEADERS,
    "test_access.py::test_the_link_becomes_a_cookie_and_leaves_the_address_bar": _HEADERS,
    "test_api_exports.py::test_every_format_is_exported_with_its_values": _TABLES,
    "test_api_foreign_logs.py::test_only_this_computer_sends_one": _HEADERS,
    "test_api_foreign.py::test_only_this_computer_fills_its_disk_and_not_all_of_it": _HEADERS,
    "test_api_live.py::test_a_slow_reader_stops_no_other_and_loses_whole_messages": _SOCKET,
    "test_api_marks.py::test_a_file_that_another_program_writes_is_not_marked": _PROGRAMS,
    "test_api_recorded_instruments.py::"
    "test_a_recording_with_instruments_as_a_table_of_others": _TABLES,
    "test_api_recordings.py::test_a_note_is_kept_in_the_file_itself": _TABLES,
    "test_api_recordings.py::test_all_rows_are_those_of_the_library": _TABLES,
    "test_api_recordings.py::test_nothing_else_can_be_reached": _SOCKET,
    "test_api_recordings.py::test_a_recording_has_its_channels_its_time_and_its_problems": _TABLES,
    "test_api_recordings.py::test_spikes_stay_when_there_are_too_many_rows": _TABLES,
    "test_dump_jobs_kept.py::test_a_dump_that_another_program_reads_is_not_deleted": _PROGRAMS,
    "test_lanes.py::test_a_loop_without_a_check_is_interrupted": _NO_PAUSE,
    "test_long_work.py::test_a_crafted_recording_holds_up_nothing_and_ends_with_its_client": (
        _SOCKET
    ),
    "test_long_work.py::test_the_end_of_the_program_does_not_wait_for_a_report": _SOCKET,
    "test_port_threads.py::test_the_unit_sends_no_stream_when_sampling_has_ended": _NO_PAUSE,
    "test_session_recorder.py::test_a_recording_is_made_with_its_markers_and_can_be_read_again": (
        _TABLES
    ),
}
