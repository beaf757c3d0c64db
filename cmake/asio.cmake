# Boost.Asio, compiled once: its users include declarations instead of the whole implementation.
find_package(Boost 1.74 REQUIRED)
find_package(Threads REQUIRED)

add_library(asio STATIC cmake/asio.cpp)
target_compile_definitions(asio PUBLIC BOOST_ASIO_SEPARATE_COMPILATION)
target_link_libraries(asio PUBLIC Boost::headers Threads::Threads)
# It is one object: a program that needs a timer shall not carry the resolver.
target_compile_options(asio PRIVATE -ffunction-sections -fdata-sections)
target_link_options(asio INTERFACE -Wl,--gc-sections)
