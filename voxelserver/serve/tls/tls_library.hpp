#pragma once

namespace terravox::tls {

/// Makes CivetWeb's TLS work with OpenSSL 3 (missing_symbol.c). Must be called before the server
/// starts; further calls do nothing. When CivetWeb later opens its TLS library, the dynamic linker
/// returns the one that is already loaded under that name.
/// @throws Error when the library next to the program cannot be loaded
void load_library();

}  // namespace terravox::tls
