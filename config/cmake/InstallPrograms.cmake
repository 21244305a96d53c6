# cmake --install BUILD --prefix P [--component C]: programs and what they read (docs/adr/0030).
# Everything is found relative to the programs, so that P can be moved. The components, in this
# order, since the manual is made of the programs that are there:
#   data      share/terravox/config     data files, of the Python package, too
#             share/doc/terravox        licences, those of what is compiled in, too
#   preview   lib/terravox/terravox-preview, with libraries that a server has no use for
#   programs  bin/terravox              the commands; the only program in the PATH
#             lib/terravox              the programs, their modules, the grabber
#             share/terravox/setup      what bin/terravox is made of
#             share/doc/terravox        the documents, changes, licences of the page
#             share/man, and for completion share/bash-completion, share/fish, share/zsh
# Those of the library (library, development) and of the Python package (python) stand in their
# folders. The library has data of its own, in a folder of its name: versions of it that are
# installed next to each other read what belongs to them.
include_guard(GLOBAL)

set(programs
  terravox-archive terravox-convert terravox-laz terravox-publish terravox-raytracer terravox-stac
  terravox-survey terravox-view terravox-voxelserver terravox_tls_symbol terravox_worlds_module)
if(NOT TERRAVOX_WHEEL)
  list(APPEND programs terravox_picture_module)
endif()
if(TERRAVOX_VDB)
  list(APPEND programs terravox_vdb_module)
endif()
# Not LIBDIR: nothing links with what is there, and its place does not hang on the machine.
set(private lib/terravox)
# Everything that is installed, as one target: for builds without tests.
add_custom_target(terravox_packaged DEPENDS
  ${programs} terravox_shared terravox_page $<$<BOOL:${TERRAVOX_PYTHON}>:terravox_python>
  $<$<BOOL:${TERRAVOX_PYTHON}>:terravox_python_sources>)
if(TERRAVOX_PREVIEW)
  add_dependencies(terravox_packaged terravox-preview)
  install(TARGETS terravox-preview COMPONENT preview RUNTIME DESTINATION ${private})
endif()
install(TARGETS ${programs} COMPONENT programs
  RUNTIME DESTINATION ${private}
  LIBRARY DESTINATION ${private})
install(PROGRAMS config/setup/installed.sh COMPONENT programs
  DESTINATION bin RENAME terravox)
install(FILES config/setup/commands.sh config/setup/commands.txt config/setup/say.sh
  COMPONENT programs DESTINATION share/terravox/setup)

# What worlds and pictures are made with, and what programs and services read besides.
set(folders_of_worlds config/blocks config/classes config/palettes config/scenes config/sources
  config/tints config/views)
set(files_of_worlds config/materials-clay.toml config/materials.toml config/voxelize.toml)
install(DIRECTORY ${folders_of_worlds} config/areas config/cluster config/nginx config/systemd
  COMPONENT data DESTINATION share/terravox/config)
install(FILES ${files_of_worlds} config/converters.toml config/licences.toml config/worker.toml
  COMPONENT data DESTINATION share/terravox/config)
set(data_of_library "share/terravox/libterravox.so.${PROJECT_VERSION}/config")
install(DIRECTORY ${folders_of_worlds} COMPONENT library DESTINATION "${data_of_library}")
install(FILES ${files_of_worlds} COMPONENT library DESTINATION "${data_of_library}")
install(FILES LICENSE THIRD_PARTY.md config/debian/copyright
  COMPONENT data DESTINATION share/doc/terravox)
install(FILES CHANGELOG.md
  COMPONENT programs DESTINATION share/doc/terravox)
# Pages lead to each other and to figures; the gallery is larger than all of them.
install(DIRECTORY docs/ COMPONENT programs DESTINATION share/doc/terravox
  PATTERN gallery EXCLUDE)
install(FILES "${PROJECT_BINARY_DIR}/voxelserver/serve/page/dist/licences.txt"
  COMPONENT programs DESTINATION share/doc/terravox RENAME licences-page.txt)

# npm builds the grabber before CMake runs (config/setup/node.sh).
string(REPLACE x86_64 x64 processor "${CMAKE_SYSTEM_PROCESSOR}")
string(REPLACE aarch64 arm64 processor "${processor}")
set(emulator)
if(CMAKE_CROSSCOMPILING)
  set(emulator ${CMAKE_CROSSCOMPILING_EMULATOR})
endif()
find_package(Python3 REQUIRED COMPONENTS Interpreter)
install(CODE "set(node \"${TERRAVOX_NODE}\")
set(processor \"${processor}\")
set(strip \"${CMAKE_STRIP}\")
set(emulator \"${emulator}\")
set(python \"${Python3_EXECUTABLE}\")
set(version \"${PROJECT_VERSION}\")
set(root \"${PROJECT_SOURCE_DIR}\")
set(grabber \"${PROJECT_SOURCE_DIR}/grabber\")
set(prefix \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\")
set(folder \"\${prefix}/${private}/grabber\")"
  COMPONENT programs)
install(SCRIPT config/cmake/install_grabber.cmake COMPONENT programs)
install(SCRIPT config/cmake/install_manual.cmake COMPONENT programs)
