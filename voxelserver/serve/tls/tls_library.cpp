#include "voxelserver/serve/tls/tls_library.hpp"

#include "common/util/folders.hpp"

namespace terravox::tls {

void load_library() {
    (void)util::open_module(TERRAVOX_TLS_LIBRARY, "TLS library");
}

}  // namespace terravox::tls
