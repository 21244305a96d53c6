#pragma once

#include <grpcpp/security/auth_context.h>
#include <openssl/x509.h>

#include <filesystem>
#include <string>
#include <string_view>

namespace terravox::net {

/// What a certificate lets its owner be. It stands in the certificate as a URI among its alternative names: kRoleUri and the role.
inline constexpr std::string_view kWorkerRole = "worker";            ///< renders for coordinators
inline constexpr std::string_view kCoordinatorRole = "coordinator";  ///< has pictures rendered; asks for states, and pauses
inline constexpr std::string_view kRoleUri = "urn:terravox:farm:";

/// @return kWorkerRole, kCoordinatorRole, or empty: it names none
[[nodiscard]] std::string role_of(X509* certificate);

/// The list of revoked certificates of a CA (X.509 CRL, PEM), which lies beside it: ca.crl for ca.pem. It is read for each connection.
[[nodiscard]] std::filesystem::path revocation_list_of(const std::filesystem::path& ca);

/// What a certificate says of its owner.
struct Certified {
    std::string role;  ///< kWorkerRole or kCoordinatorRole
    std::string name;  ///< its common name
};

/// What the certificate says that the other end of a TLS connection has shown, which gRPC has found to be of this CA.
/// @param ca file of the CA's certificate
/// @throws RefusedError for a certificate without kFarmName or a role, or one that is revoked; Error for a list of revoked ones that cannot
/// be read, or that this CA has not signed: then nobody is let in
[[nodiscard]] Certified certified_peer(const grpc::AuthContext& context, const std::filesystem::path& ca);

}  // namespace terravox::net
