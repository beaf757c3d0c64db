# What is installed, as Debian packages, a component each: romano-broker, romano-robot, romano-tools, python3-romano.
#
#     cd build/release && cpack        (for robots with a 64-bit ARM: build/arm64, see cmake/arm64-sysroot)

set(package_folder ${PROJECT_SOURCE_DIR}/cmake/package)
set(package_build ${PROJECT_BINARY_DIR}/package)

# The broker's configuration file is what the broker itself says of its settings. One of them is set: the packaged
# robot looks for a broker, and so the packaged broker answers.
add_custom_command(OUTPUT ${package_build}/broker.toml
    COMMAND romano-broker --default-config > ${package_build}/broker.toml
    COMMAND sed -i "s/^# discovery-group = .*/discovery-group = [\"default\"]/" ${package_build}/broker.toml
    DEPENDS romano-broker VERBATIM)

# manual(PROGRAM COMPONENT SUMMARY): the program's --help as a manual page, and its completion in bash.
function(manual program component summary)
    set(page ${package_build}/${program}.1)
    add_custom_command(OUTPUT ${page}.gz
        COMMAND ${package_folder}/man-page ${summary} ${program} ${CMAKE_CROSSCOMPILING_EMULATOR}
                $<TARGET_FILE:${program}> > ${page}
        COMMAND gzip -9nf ${page}
        DEPENDS ${program} ${package_folder}/man-page VERBATIM)
    install(FILES ${page}.gz DESTINATION share/man/man1 COMPONENT ${component})
    install(FILES ${package_folder}/bash-completion DESTINATION share/bash-completion/completions
            RENAME ${program} COMPONENT ${component})
    set_property(GLOBAL APPEND PROPERTY romano_manuals ${page}.gz)
endfunction()
manual(romano-broker broker "MQTT-SN broker, alone or as one of a cluster")
manual(romano-broker-member broker "what romano-broker becomes in a cluster")
manual(romano-broker-uplink broker "what romano-broker becomes with an uplink")
manual(romano-broker-robot broker "robot and broker in one")
manual(romano-host broker "machine of a ROMANO testbed")
manual(romano-robot robot "ROMANO robot that finds its broker by itself")
manual(romano-radio robot "radio of a robot whose controller is another chip")
manual(romano tools "commands for ROMANO brokers and robots")
get_property(manuals GLOBAL PROPERTY romano_manuals)
add_custom_target(packaged_configuration ALL DEPENDS ${package_build}/broker.toml ${manuals})

# What a broker becomes when it has a domain or an uplink is no command of people's, and stands beside it all the same.
install(TARGETS romano-broker romano-broker-member romano-broker-uplink romano-broker-robot romano-host
        RUNTIME DESTINATION bin COMPONENT broker)
install(FILES ${package_build}/broker.toml DESTINATION /etc/romano COMPONENT broker)
install(FILES broker/daemon/package/romano-broker.service
        DESTINATION /lib/systemd/system COMPONENT broker)
install(FILES broker/daemon/package/address-takeover.conf broker/daemon/package/realtime.conf
        DESTINATION share/doc/romano-broker/examples COMPONENT broker)
# The package itself uses this one, and may not rely on what is in share/doc.
install(FILES broker/daemon/package/address-takeover.conf DESTINATION share/romano-broker
        COMPONENT broker)
install(FILES broker/daemon/README.md DESTINATION share/doc/romano-broker COMPONENT broker)

install(TARGETS romano-robot romano-radio RUNTIME DESTINATION bin COMPONENT robot)
install(FILES firmware/posix/package/romano-robot.default
        DESTINATION /etc/default RENAME romano-robot COMPONENT robot)
install(FILES firmware/posix/package/romano-robot.service
        DESTINATION /lib/systemd/system COMPONENT robot)
install(FILES firmware/README.md DESTINATION share/doc/romano-robot COMPONENT robot)

install(TARGETS romano RUNTIME DESTINATION bin COMPONENT tools)
install(FILES README.md DESTINATION share/doc/romano-tools COMPONENT tools)
install(FILES experiments/README.md DESTINATION share/doc/romano-tools RENAME experiments.md
        COMPONENT tools)
install(FILES experiments/web/README.md DESTINATION share/doc/romano-tools RENAME web.md COMPONENT tools)
install(FILES experiments/recording/README.md DESTINATION share/doc/romano-tools RENAME recording.md COMPONENT tools)
install(FILES experiments/TESTBED.md DESTINATION share/doc/romano-tools COMPONENT tools)
install(FILES experiments/testbed/hosts.toml DESTINATION share/doc/romano-tools/examples COMPONENT tools)
install(FILES experiments/demo.toml DESTINATION share/doc/romano-tools/examples COMPONENT tools)
install(DIRECTORY experiments/sweeps DESTINATION share/doc/romano-tools/examples COMPONENT tools
        FILES_MATCHING PATTERN "*.toml")

# Python reads it where Debian's own packages are, whatever the architecture.
install(DIRECTORY romano/python/src/romano DESTINATION lib/python3/dist-packages COMPONENT python
        FILES_MATCHING PATTERN "*.py" PATTERN py.typed PATTERN __pycache__ EXCLUDE)
install(FILES romano/python/README.md DESTINATION share/doc/python3-romano COMPONENT python)
install(DIRECTORY romano/python/examples DESTINATION share/doc/python3-romano COMPONENT python
        FILES_MATCHING PATTERN "*.py")

# What has changed is told by the history of the sources; a package must name its version all the same.
set(ROMANO_MAINTAINER "The ROMANO project <romano@example.org>" CACHE STRING
    "Whom the packages name as their maintainer")
string(TIMESTAMP today "%a, %d %b %Y 00:00:00 +0000" UTC)
foreach(component broker robot tools python)
    set(package romano-${component})
    if(component STREQUAL python)
        set(package python3-romano)
    endif()
    install(FILES ${package_folder}/copyright DESTINATION share/doc/${package} COMPONENT ${component})
    configure_file(${package_folder}/changelog.in ${package_build}/${component}/changelog @ONLY)
    execute_process(COMMAND gzip -9nf ${package_build}/${component}/changelog)
    install(FILES ${package_build}/${component}/changelog.gz DESTINATION share/doc/${package}
            COMPONENT ${component})
endforeach()

# maintainer_scripts(COMPONENT UNIT STARTS STATE CONFFILES [ASKS]): the service of a package is started with
# it, or not, and its state goes when the package is purged. ASKS: a folder with what debconf asks (config, templates) and
# what becomes of the answers (configure, forget).
function(maintainer_scripts component unit starts state conffiles)
    set(folder ${package_build}/${component})
    set(questions)
    if(ARGN)
        file(READ ${ARGN}/configure configure)
        file(READ ${ARGN}/forget forget)
        set(questions ${ARGN}/config ${ARGN}/templates)
    endif()
    foreach(script postinst prerm postrm)
        configure_file(${package_folder}/${script}.in ${folder}/${script} @ONLY
                       FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ
                                        GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
    endforeach()
    file(WRITE ${folder}/conffiles "${conffiles}\n")
    string(TOUPPER ${component} name)
    set(CPACK_DEBIAN_${name}_PACKAGE_CONTROL_EXTRA
        ${folder}/conffiles ${folder}/postinst ${folder}/prerm ${folder}/postrm ${questions} PARENT_SCOPE)
endfunction()
maintainer_scripts(broker romano-broker.service true romano /etc/romano/broker.toml
                   ${PROJECT_SOURCE_DIR}/broker/daemon/package/debconf)
# A robot wants an id before it starts.
maintainer_scripts(robot romano-robot.service false "" /etc/default/romano-robot)

set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL broker robot tools python)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_CONTACT ${ROMANO_MAINTAINER})
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION net)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
if(CMAKE_CROSSCOMPILING)  # dpkg-shlibdeps asks this machine's packages for those of the robot
    set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
    set(CPACK_PROJECT_CONFIG_FILE ${package_folder}/arm64.cmake)
endif()

set(CPACK_DEBIAN_BROKER_PACKAGE_NAME romano-broker)
set(CPACK_DEBIAN_BROKER_PACKAGE_DEPENDS "debconf (>= 0.5) | debconf-2.0")
set(CPACK_DEBIAN_BROKER_PACKAGE_SUGGESTS romano-tools)  # --web
set(CPACK_DEBIAN_BROKER_DESCRIPTION "distributed MQTT-SN broker for robots
 A light MQTT-SN 1.2 broker: alone on one UDP port, or one of a cluster over
 Eclipse Cyclone DDS whose members take each other's clients and addresses over.")
set(CPACK_DEBIAN_ROBOT_PACKAGE_NAME romano-robot)
set(CPACK_DEBIAN_ROBOT_DESCRIPTION "ROMANO on a robot with Linux
 A ROMANO robot that finds its broker by itself, and the radio side of a robot
 whose controller is another chip.")
set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME romano-tools)
set(CPACK_DEBIAN_TOOLS_DESCRIPTION "commands for ROMANO brokers and robots
 Publish, subscribe, look at brokers and robots, steer robots, and experiment.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-romano)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.11)")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-pandas")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
    ${package_folder}/python/postinst ${package_folder}/python/prerm)
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "ROMANO and MQTT-SN for Python programs
 An MQTT-SN 1.2 client for asyncio, robots and their commands, and the results
 of experiments as tables.")

include(CPack)
