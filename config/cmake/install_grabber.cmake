# Bundles the grabber into a prefix. Run by cmake --install (InstallPrograms.cmake), which sets
#   node       the program Node.js
#   grabber    folder of the sources of the grabber, built
#   folder     where it goes; what is there is replaced
#   processor  what it will run on, as Node.js names it: x64, arm64
#   strip      the program
if(NOT EXISTS "${grabber}/dist/main.js")
  message(FATAL_ERROR "Install the grabber: ${grabber}/dist/main.js is missing; "
          "run ./terravox deps first")
endif()
message(STATUS "Installing: ${folder}")
execute_process(COMMAND "${node}" "${grabber}/bundle.js" "${folder}" "${processor}"
                COMMAND_ERROR_IS_FATAL ANY)
# The stripped form is what the programs have, too.
if(CMAKE_INSTALL_DO_STRIP)
  file(GLOB_RECURSE compiled "${folder}/node_modules/*.node")
  execute_process(COMMAND "${strip}" --strip-unneeded ${compiled} COMMAND_ERROR_IS_FATAL ANY)
endif()
