// What a machine of a testbed is told to run.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace romano::experiments {

/// One life of a program.
struct ProgramOrder {
    std::uint32_t number = 0;  // in this testbed
    std::uint32_t life = 1;
    std::string program;  // romano-broker, romano-robot
    std::string name;
    std::vector<std::string> arguments;
    std::string trace;  // name of the file for what it prints
    std::string lease;  // an address that the machine shall have meanwhile; empty: none
    std::uint16_t metrics_port = 0;  // where it serves its metrics, on 127.0.0.1; 0: nowhere
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ProgramOrder, number, life, program, name, arguments, trace,
                                   lease, metrics_port)

/// What goes on there when nobody is connected.
struct KeptPrograms {
    std::string folder;
    std::vector<std::string> addresses;
    std::vector<ProgramOrder> programs;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(KeptPrograms, folder, addresses, programs)

}  // namespace romano::experiments
