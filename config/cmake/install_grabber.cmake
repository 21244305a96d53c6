# Bundles the grabber into a prefix. Run by cmake --install (InstallPrograms.cmake), which sets
#   node     the program Node.js
#   grabber  folder of the sources of the grabber, built
#   folder   where it goes; what is there is replaced
#   sqlite   the compiled part of better-sqlite3, where it is not that of the grabber
#   strip    the program
if(NOT EXISTS "${grabber}/dist/main.js")
  message(FATAL_ERROR "Install the grabber: ${grabber}/dist/main.js is missing; "
          "run ./terravox deps first")
endif()
message(STATUS "Installing: ${folder}")
execute_process(COMMAND "${node}" "${grabber}/bundle.js" "${folder}"
                COMMAND_ERROR_IS_FATAL ANY)
set(compiled "${folder}/node_modules/better-sqlite3/build/Release/better_sqlite3.node")
if(sqlite)
  file(COPY_FILE "${sqlite}" "${compiled}")
endif()
# The stripped form is what the programs have, too.
if(CMAKE_INSTALL_DO_STRIP)
  execute_process(COMMAND "${strip}" --strip-unneeded "${compiled}" COMMAND_ERROR_IS_FATAL ANY)
endif()
