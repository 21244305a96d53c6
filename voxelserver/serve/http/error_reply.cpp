#include "voxelserver/serve/http/error_reply.hpp"

#include <exception>
#include <new>

#include "common/util/log.hpp"
#include "common/voxel/unreachable_error.hpp"
#include "voxelserver/serve/boxes/admission_control.hpp"
#include "voxelserver/serve/http/service.hpp"

namespace terravox::http {

Response reply_to_current_exception(const Request& request) {
    try {
        throw;
    } catch (const boxes::OverloadedError& e) {
        return problem(503, e.what()).add("Retry-After", "1");
    } catch (const voxel::UnreachableError& e) {
        // The address of the other server is only for the operator of this one.
        util::log_error("{} {}: {}", request.method, request.path, e.what());
        return problem(502, kUnreachable).add("Retry-After", "5");
    } catch (const std::bad_alloc&) {
        util::log_error("{} {}: out of memory", request.method, request.path);
        return problem(500, "out of memory");
    } catch (const std::exception& e) {
        util::log_error("{} {}: {}", request.method, request.path, e.what());
        return problem(500, without_folders(e.what()));
    } catch (...) {
        util::log_error("{} {}: unknown error", request.method, request.path);
        return problem(500, "unknown error");
    }
}

}  // namespace terravox::http
