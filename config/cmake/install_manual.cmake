# Makes man pages and completions of what the installed programs say of their options. Run by
# cmake --install after the programs and the grabber (InstallPrograms.cmake), which sets
#   root     of the sources
#   prefix   where the programs are
#   node, python, version
#   emulator that programs are started with, where they are for another processor
# The date of the pages is SOURCE_DATE_EPOCH, or that of the last commit, so that they are the same
# whenever they are made.
set(epoch "$ENV{SOURCE_DATE_EPOCH}")
if(NOT epoch)
  execute_process(COMMAND git -C "${root}" log -1 --format=%ct
                  OUTPUT_VARIABLE epoch OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT epoch)
  file(TIMESTAMP "${root}/CHANGELOG.md" epoch "%s" UTC)
endif()
set(ENV{SOURCE_DATE_EPOCH} "${epoch}")
string(TIMESTAMP date "%Y-%m-%d" UTC)
message(STATUS "Installing: ${prefix}/share/man")
execute_process(COMMAND "${python}" -B "${root}/config/manual/make.py" "${prefix}"
                --node "${node}" --emulator "${emulator}"
                --version "${version}" --date "${date}"
                COMMAND_ERROR_IS_FATAL ANY)
