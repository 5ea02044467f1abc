//! The fields of classes. Binary files do not say what their values are.

/// What a value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// So many floating-point numbers.
    Floats(usize),
    Integer,
    /// A word or a text.
    Text,
    /// Words up to an empty one.
    Mask,
    Image,
    Node,
}

/// A class.
#[derive(Clone, Copy, Debug)]
pub(super) struct Class(&'static str);

impl Class {
    /// The class of this name, if it is known.
    pub(super) fn of(name: &str) -> Option<Self> {
        let is_it = |line: &&str| {
            line.split(' ').next().is_some_and(|word| word.trim_end_matches('*') == name)
        };
        CLASSES.lines().find(is_it).map(Self)
    }

    /// Whether it has children.
    pub(super) fn is_group(self) -> bool {
        self.0.split(' ').next().is_some_and(|word| word.ends_with('*'))
    }

    pub(super) fn has_fields(self) -> bool {
        self.0.contains('=')
    }

    /// What the values of a field are, and whether there may be any number of them.
    pub(super) fn field(self, name: &str) -> Option<(Kind, bool)> {
        let mut fields = self.0.split(' ').skip(1).filter_map(|field| field.split_once('='));
        let (_, kind) = fields.find(|(field, _)| *field == name)?;
        let kind_of = match kind.trim_end_matches('+') {
            "f" => Kind::Floats(1),
            "2" => Kind::Floats(2),
            "3" => Kind::Floats(3),
            "4" => Kind::Floats(4),
            "m" => Kind::Floats(16),
            "i" => Kind::Integer,
            "k" => Kind::Mask,
            "p" => Kind::Image,
            "n" => Kind::Node,
            _ => Kind::Text,
        };
        Some((kind_of, kind.ends_with('+')))
    }
}

/// A class a line; `*` marks those with children. A field is `f` for a float, `2`, `3` and `4` for several,
/// `m` for a matrix, `i` for an integer, `s` for a word or text, `k` for a mask, `p` for an image and `n` for
/// a node; `+` stands for any number of them.
const CLASSES: &str = "\
Group*
TransformSeparator*
Separator* renderCaching=s boundingBoxCaching=s renderCulling=s pickCulling=s
Annotation* renderCaching=s boundingBoxCaching=s renderCulling=s pickCulling=s
Selection* policy=s renderCaching=s boundingBoxCaching=s renderCulling=s pickCulling=s
LocateHighlight* mode=s style=s color=3 renderCaching=s boundingBoxCaching=s renderCulling=s pickCulling=s
WWWAnchor* name=s description=s map=s renderCaching=s boundingBoxCaching=s renderCulling=s pickCulling=s
Switch* whichChild=i
Blinker* whichChild=i speed=f on=i
LOD* center=3 range=f+
LevelOfDetail* screenArea=f+
Array* numElements1=i numElements2=i numElements3=i separation1=3 separation2=3 separation3=3 origin=s
MultipleCopy* matrix=m+
File name=s
WWWInline name=s bboxCenter=3 bboxSize=3 alternateRep=n
Info string=s
Label label=s
Font name=s size=f
FontStyle name=s size=f family=s style=k
Coordinate3 point=3+
Coordinate4 point=4+
Normal vector=3+
NormalBinding value=s
Material ambientColor=3+ diffuseColor=3+ specularColor=3+ emissiveColor=3+ shininess=f+ transparency=f+
MaterialBinding value=s
BaseColor rgb=3+
PackedColor orderedRGBA=i+ rgba=i+
LightModel model=s
DrawStyle style=s pointSize=f lineWidth=f linePattern=i
ShapeHints vertexOrdering=s shapeType=s faceType=s creaseAngle=f
Complexity type=s value=f textureQuality=f
PickStyle style=s
ColorIndex index=i+
Environment ambientIntensity=f ambientColor=3 attenuation=3 fogType=s fogColor=3 fogVisibility=f
ClipPlane plane=4 on=i
Texture2 filename=s image=p wrapS=s wrapT=s model=s blendColor=3
Texture2Transform translation=2 rotation=f scaleFactor=2 center=2
TextureCoordinate2 point=2+
TextureCoordinateBinding value=s
TextureCoordinateDefault
TextureCoordinateEnvironment
TextureCoordinatePlane directionS=3 directionT=3
ProfileCoordinate2 point=2+
ProfileCoordinate3 point=3+
LinearProfile index=i+ linkage=s
NurbsProfile index=i+ linkage=s knotVector=f+
VertexProperty vertex=3+ normal=3+ texCoord=2+ orderedRGBA=i+ materialBinding=s normalBinding=s
Transform translation=3 rotation=4 scaleFactor=3 scaleOrientation=4 center=3
Translation translation=3
Rotation rotation=4
RotationXYZ axis=s angle=f
Scale scaleFactor=3
MatrixTransform matrix=m
ResetTransform whatToReset=k
Units units=s
AntiSquish sizing=s recalcAlways=i
Rotor rotation=4 speed=f on=i
Pendulum rotation=4 rotation0=4 rotation1=4 speed=f on=i
Shuttle translation=3 translation0=3 translation1=3 speed=f on=i
Sphere radius=f
Cube width=f height=f depth=f
Cone parts=k bottomRadius=f height=f
Cylinder parts=k radius=f height=f
FaceSet vertexProperty=n startIndex=i numVertices=i+
LineSet vertexProperty=n startIndex=i numVertices=i+
TriangleStripSet vertexProperty=n startIndex=i numVertices=i+
PointSet vertexProperty=n startIndex=i numPoints=i
QuadMesh vertexProperty=n startIndex=i verticesPerColumn=i verticesPerRow=i
IndexedFaceSet vertexProperty=n coordIndex=i+ materialIndex=i+ normalIndex=i+ textureCoordIndex=i+
IndexedLineSet vertexProperty=n coordIndex=i+ materialIndex=i+ normalIndex=i+ textureCoordIndex=i+
IndexedTriangleStripSet vertexProperty=n coordIndex=i+ materialIndex=i+ normalIndex=i+ textureCoordIndex=i+
NurbsCurve numControlPoints=i knotVector=f+
IndexedNurbsCurve numControlPoints=i coordIndex=i+ knotVector=f+
NurbsSurface numUControlPoints=i numVControlPoints=i numSControlPoints=i numTControlPoints=i uKnotVector=f+ vKnotVector=f+ sKnotVector=f+ tKnotVector=f+
IndexedNurbsSurface numUControlPoints=i numVControlPoints=i coordIndex=i+ uKnotVector=f+ vKnotVector=f+ numSControlPoints=i numTControlPoints=i textureCoordIndex=i+ sKnotVector=f+ tKnotVector=f+
Text2 string=s+ spacing=f justification=s
Text3 string=s+ spacing=f justification=s parts=k
AsciiText string=s+ spacing=f justification=s width=f+
PointLight on=i intensity=f color=3 location=3
DirectionalLight on=i intensity=f color=3 direction=3
SpotLight on=i intensity=f color=3 location=3 direction=3 dropOffRate=f cutOffAngle=f
PerspectiveCamera viewportMapping=s position=3 orientation=4 aspectRatio=f nearDistance=f farDistance=f focalDistance=f heightAngle=f
OrthographicCamera viewportMapping=s position=3 orientation=4 aspectRatio=f nearDistance=f farDistance=f focalDistance=f height=f
";
