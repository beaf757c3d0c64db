# A target per folder, in the words of the design's three rings.

# romano_core(NAME SOURCES ... LIBRARIES ...): wire code or a core. No exceptions, includes rooted at
# the repository. Optimised a little also for Debug: the tests run hundreds of simulated clusters.
function(romano_core name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LIBRARIES")
    add_library(${name} STATIC ${arg_SOURCES})
    target_include_directories(${name} PUBLIC ${PROJECT_SOURCE_DIR})
    target_compile_options(${name} PRIVATE -fno-exceptions $<$<CONFIG:Debug>:-O1>)
    target_link_libraries(${name} PUBLIC ${arg_LIBRARIES} PRIVATE project_warnings)
endfunction()

# romano_shell(NAME SOURCES ... LIBRARIES ... [PRIVATE_LIBRARIES ...]): code that does I/O.
function(romano_shell name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LIBRARIES;PRIVATE_LIBRARIES")
    add_library(${name} STATIC ${arg_SOURCES})
    target_include_directories(${name} PUBLIC ${PROJECT_SOURCE_DIR})
    target_link_libraries(${name} PUBLIC ${arg_LIBRARIES}
                                  PRIVATE project_warnings ${arg_PRIVATE_LIBRARIES})
endfunction()

# romano_program(NAME SOURCES ... LIBRARIES ...): an executable in build/<preset>/bin.
function(romano_program name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LIBRARIES")
    add_executable(${name} ${arg_SOURCES})
    target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
    target_link_libraries(${name} PRIVATE ${arg_LIBRARIES} project_warnings)
endfunction()

# romano_test(NAME SOURCES ... LIBRARIES ...): one GoogleTest executable for a folder of tests, whose
# label in ctest is NAME.
function(romano_test name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "TIMEOUT" "SOURCES;LIBRARIES")
    if(NOT arg_TIMEOUT)
        set(arg_TIMEOUT 60)
    endif()
    add_executable(${name} ${arg_SOURCES})
    target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
    target_link_libraries(${name} PRIVATE ${arg_LIBRARIES} project_warnings GTest::gmock_main)
    set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
    gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 120
                         PROPERTIES TIMEOUT ${arg_TIMEOUT} LABELS ${name})
endfunction()
