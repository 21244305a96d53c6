#pragma once

namespace terravox::tls {

/// Makes CivetWeb's TLS work with OpenSSL 3 (missing_symbol.c). To be called before the server
/// starts; does nothing a second time. The dynamic linker gives whoever opens a library the one
/// that is loaded under that name already.
/// @throws Error when the library beside the program cannot be loaded
void load_library();

}  // namespace terravox::tls
