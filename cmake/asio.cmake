# Boost.Asio, compiled once: its users include declarations instead of the whole implementation.
find_package(Boost 1.74 REQUIRED)
find_package(Threads REQUIRED)

add_library(asio STATIC cmake/asio.cpp)
target_compile_definitions(asio PUBLIC BOOST_ASIO_SEPARATE_COMPILATION)
target_link_libraries(asio PUBLIC Boost::headers Threads::Threads)
# It is one object: a program that needs a timer shall not carry the resolver.
target_compile_options(asio PRIVATE -ffunction-sections -fdata-sections)
target_link_options(asio INTERFACE -Wl,--gc-sections)

# TLS over it, by OpenSSL, for those programs that need it.
find_package(OpenSSL REQUIRED)
add_library(asio_ssl STATIC cmake/asio_ssl.cpp)
target_link_libraries(asio_ssl PUBLIC asio OpenSSL::SSL)
target_compile_options(asio_ssl PRIVATE -ffunction-sections -fdata-sections)
